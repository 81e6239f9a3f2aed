// SPDX-License-Identifier: BSD-3-Clause
// The regressions of a study: √Y on b2, β on b1, the terms that F-tests keep, and predictions for a
// stem; and how the largest stable explicit step depends on bond damping and Young's modulus.
#pragma once

#include "core/interval.hpp"
#include "reduce/linear_regression.hpp"
#include "reduce/population_statistics.hpp"

#include <cstddef>
#include <optional>
#include <span>
#include <string>
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
    int round = 0; ///< tests of one round start from the same model; at most one term is dropped
    bool dropped = false;
};

/// A model after elimination.
struct InteractionModel {
    std::vector<Term> terms;              ///< kept, in the order of `regression.coefficients`
    LinearRegression regression;          ///< of the kept terms
    std::vector<EliminationTest> history; ///< every test made, in order
    double full_adjusted_r_squared = 0.0; ///< of the model with all four terms
};

/// Backward elimination from the full model (Schramm et al. 2019, section on the DOE): among the
/// removable terms, the one with the largest p is dropped as long as p >= significance, that is,
/// while the model without it is not rejected. The intercept stays, and a predictor stays with its
/// interaction. `significance`: in (0, 1). Errors as of `regress`.
[[nodiscard]] InteractionModel reduce_interaction_model(const PredictorPair& predictors,
                                                        std::span<const double> response,
                                                        double significance = 0.05);

/// The computed points of a study; four spans of one length.
struct StudyPoints {
    std::span<const double> bond_youngs_modulus; ///< Y, Pa
    std::span<const double> bond_damping;        ///< β
    std::span<const double> decay_per_cycle;     ///< fitted b1 in normalised time
    std::span<const double> frequency;           ///< fitted b2, Hz
};

/// response = intercept + slope · predictor: Eq. 12 or 13 of Schramm et al. (2019).
struct SinglePredictorLaw {
    Term predictor = Term::First; ///< First: decay per cycle; Second: frequency
    Coefficient intercept;
    Coefficient slope;
    LinearRegression regression;   ///< adjusted R², sigma, covariance; without residuals
    double largest_residual = 0.0; ///< absolute, per cent of the largest observed response
};

/// The interaction model of both predictors after the F-tests.
struct ReducedModel {
    InteractionModel model;
    NestedTest single_predictor_against_full; ///< p < 0.05: the single-predictor law is rejected
};

/// All results for one response.
struct ResponseRegression {
    std::size_t points = 0;
    SinglePredictorLaw single;
    std::optional<ReducedModel> reduced;
    std::string no_reduced_reason; ///< one sentence if `reduced` is empty
};

/// A response that could be regressed, or the reason why it could not.
struct RegressionOutcome {
    std::optional<ResponseRegression> regression;
    std::string reason; ///< one sentence if `regression` is empty
};

struct StudyRegression {
    std::size_t points_used = 0;
    std::size_t points_excluded = 0;       ///< a value was not finite or Y was not positive
    RegressionOutcome sqrt_youngs_modulus; ///< √Y in √Pa; single law on the frequency (Eq. 12)
    RegressionOutcome bond_damping;        ///< β; single law on the decay per cycle (Eq. 13)
    core::Interval decay_per_cycle;        ///< of the points
    core::Interval frequency;              ///< Hz
};

/// Regresses √Y and β on the fitted decay per cycle and frequency, each by its single-predictor law
/// and by the full interaction model reduced with nested F-tests at `significance`, in (0, 1).
/// Designs that do not determine a law give a reason instead: fewer than 3 usable points, one value
/// only of the response or of its predictor.
[[nodiscard]] StudyRegression regress_study(const StudyPoints& points, double significance = 0.05);

/// Parameters of Eq. 1 fitted to a stem. Standard errors of 0 mean that the reading is exact.
struct StemReading {
    Estimate decay_per_cycle;
    Estimate frequency; ///< Hz
};

/// One parameter of the stem by both laws; a law that the study does not determine is empty.
struct ParameterPrediction {
    std::optional<Prediction> by_single_law;
    std::optional<Prediction> by_reduced_model;
    std::string reason; ///< one sentence if any of the two is empty
};

struct StemPrediction {
    ParameterPrediction bond_youngs_modulus; ///< Y, Pa
    ParameterPrediction bond_damping;        ///< β
    bool is_inside_design = false;           ///< both readings lie in the study's ranges
};

/// Y and β of a stem by the single-predictor laws (Eqs. 12 and 13) and by the reduced interaction
/// models. The standard errors include the uncertainty of the coefficients, the scatter of the
/// study (in Prediction::standard_error) and the reading's own errors through the law's slopes,
/// taken as independent. Y is the square of the predicted √Y: its standard errors are
/// 2√Y times those of √Y, its interval the square of that of √Y.
/// A law that gives √Y <= 0 is left empty with a reason. Throws core::NumericalError (FitFailed) if
/// the reading is not finite.
[[nodiscard]] StemPrediction predict_stem(const StudyRegression& study, const StemReading& reading);

/// A stem whose limit is known.
struct TimestepPoint {
    double bond_youngs_modulus = 0.0; ///< Y, Pa
    double bond_damping = 0.0;        ///< β
    double bond_time = 0.0;           ///< τ = √(m/k_n), s
    double limit = 0.0;               ///< largest stable step Δt, s
};

/// A fitted law.
struct TimestepLaw {
    LinearRegression regression;   ///< of the law in the form in which it is linear
    std::vector<double> residuals; ///< (points used), Δt observed/fitted − 1
    double largest_residual = 0.0; ///< of their absolute values
};

/// A law, or the reason why the points do not determine it.
struct TimestepLawOutcome {
    std::optional<TimestepLaw> law;
    std::string reason; ///< one sentence if `law` is empty
};

struct TimestepRegression {
    std::size_t points_used = 0;
    std::size_t points_excluded = 0; ///< a value was not finite, or Y, τ or Δt was not positive
    /// Velocity Verlet on one damped oscillator is stable up to the root h of h²ω² + 2hc = 4, with
    /// ω² ∝ 1/τ² and c ∝ β/τ. With u = τ/Δt that is u² = A + B βu: coefficients "A" and "B". Axial
    /// waves of a long chain of equal spheres have A = 1 and, with the damping factor 2 and reduced
    /// masses, B = 2√2.
    TimestepLawOutcome damped_oscillator;
    /// The form of the authors' rule, Δt = τ/(a + bβ): coefficients "a" and "b".
    TimestepLawOutcome rule_form;
};

/// Fits both laws by least squares of relative deviations: rows are divided by their
/// right-hand sides, because limits span orders of magnitude.
[[nodiscard]] TimestepRegression regress_timesteps(std::span<const TimestepPoint> points);

} // namespace culm::reduce
