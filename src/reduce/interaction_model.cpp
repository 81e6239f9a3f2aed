// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/interaction_model.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <array>
#include <optional>

#include <fmt/format.h>

namespace culm::reduce {

namespace {

constexpr std::array all_terms = {Term::Intercept, Term::First, Term::Second, Term::Interaction};

std::vector<Term> without(const std::vector<Term>& terms, Term dropped) {
    std::vector<Term> rest;
    std::ranges::copy_if(terms, std::back_inserter(rest), [&](Term t) { return t != dropped; });
    return rest;
}

/// The terms that no other term of the model needs.
std::vector<Term> droppable(const std::vector<Term>& terms) {
    if (std::ranges::find(terms, Term::Interaction) != terms.end())
        return {Term::Interaction};
    return without(terms, Term::Intercept);
}

} // namespace

std::string term_name(Term term, const PredictorPair& predictors) {
    switch (term) {
    case Term::Intercept:
        return "intercept";
    case Term::First:
        return predictors.first_name;
    case Term::Second:
        return predictors.second_name;
    case Term::Interaction:
        break;
    }
    return predictors.first_name + ":" + predictors.second_name;
}

double term_value(Term term, double first, double second) {
    switch (term) {
    case Term::Intercept:
        return 1.0;
    case Term::First:
        return first;
    case Term::Second:
        return second;
    case Term::Interaction:
        break;
    }
    return first * second;
}

LinearRegression regress_on_terms(const PredictorPair& predictors, std::span<const double> response,
                                  std::span<const Term> terms) {
    if (predictors.first.size() != response.size() || predictors.second.size() != response.size())
        throw core::NumericalError(
            core::FailureKind::FitFailed,
            fmt::format("the predictors have {} and {} values for {} responses",
                        predictors.first.size(), predictors.second.size(), response.size()));
    Eigen::MatrixXd design(static_cast<Eigen::Index>(response.size()),
                           static_cast<Eigen::Index>(terms.size()));
    std::vector<std::string> names;
    for (std::size_t j = 0; j < terms.size(); ++j) {
        names.push_back(term_name(terms[j], predictors));
        for (std::size_t i = 0; i < response.size(); ++i)
            design(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
                term_value(terms[j], predictors.first[i], predictors.second[i]);
    }
    return regress(design, response, names);
}

LinearRegression regress_full(const PredictorPair& predictors, std::span<const double> response) {
    return regress_on_terms(predictors, response, all_terms);
}

InteractionModel reduce_interaction_model(const PredictorPair& predictors,
                                          std::span<const double> response, double significance) {
    if (!(significance > 0.0 && significance < 1.0))
        throw core::NumericalError(
            core::FailureKind::FitFailed,
            fmt::format("the significance of the F-tests is {:g}, it must lie between 0 and 1",
                        significance));
    InteractionModel model;
    model.terms.assign(all_terms.begin(), all_terms.end());
    model.regression = regress_full(predictors, response);
    model.full_adjusted_r_squared = model.regression.adjusted_r_squared;
    for (int round = 0; model.terms.size() > 1; ++round) {
        std::optional<std::size_t> weakest;
        LinearRegression without_weakest;
        for (const Term term : droppable(model.terms)) {
            LinearRegression reduced =
                regress_on_terms(predictors, response, without(model.terms, term));
            const NestedTest test = nested_f_test(reduced, model.regression);
            model.history.push_back({term, term_name(term, predictors), test, round, false});
            if (!weakest || test.p_value > model.history[*weakest].test.p_value) {
                weakest = model.history.size() - 1;
                without_weakest = std::move(reduced);
            }
        }
        EliminationTest& candidate = model.history[*weakest];
        if (candidate.test.p_value < significance)
            break;
        candidate.dropped = true;
        model.terms = without(model.terms, candidate.term);
        model.regression = std::move(without_weakest);
    }
    return model;
}

} // namespace culm::reduce
