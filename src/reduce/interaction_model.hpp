// SPDX-License-Identifier: BSD-3-Clause
// The interaction model of two predictors, reduced term by term with nested F-tests.
#pragma once

#include "reduce/linear_regression.hpp"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace culm::reduce {

/// The terms of response ~ 1 + x1 + x2 + x1·x2.
enum class Term { Intercept, First, Second, Interaction };

/// Two predictors with their names; values of equal length, one per point.
struct PredictorPair {
    std::string first_name;
    std::string second_name;
    std::span<const double> first;
    std::span<const double> second;
};

/// One F-test of the elimination: the current model without `term` against the current model.
struct EliminationTest {
    Term term = Term::Intercept;
    std::string name;
    NestedTest test;
    int round = 0; ///< tests of one round start from the same model; at most one term goes in each
    bool dropped = false;
};

/// A model after elimination.
struct InteractionModel {
    std::vector<Term> terms;              ///< kept, in the order of `regression.coefficients`
    LinearRegression regression;          ///< of the kept terms
    std::vector<EliminationTest> history; ///< every test made, in order
    double full_adjusted_r_squared = 0.0; ///< of the model with all four terms
};

/// Name of a term: "intercept", a predictor's name, or both names joined by ':'.
[[nodiscard]] std::string term_name(Term term, const PredictorPair& predictors);

/// The regressor of a term at one point.
[[nodiscard]] double term_value(Term term, double first, double second);

/// Least squares of the response on the given terms. Errors as of `regress`.
[[nodiscard]] LinearRegression regress_on_terms(const PredictorPair& predictors,
                                                std::span<const double> response,
                                                std::span<const Term> terms);

/// All four terms.
[[nodiscard]] LinearRegression regress_full(const PredictorPair& predictors,
                                            std::span<const double> response);

/// Backward elimination from the full model (Schramm et al. 2019, section on the DOE): of the terms
/// that may go, the one with the largest p is dropped while the model without it is not rejected,
/// p >= significance. The intercept stays; a predictor stays while its interaction is in the model.
/// Errors as of `regress`; core::NumericalError too if significance is not in (0, 1).
[[nodiscard]] InteractionModel reduce_interaction_model(const PredictorPair& predictors,
                                                        std::span<const double> response,
                                                        double significance = 0.05);

} // namespace culm::reduce
