// SPDX-License-Identifier: BSD-3-Clause
// A study's fits turned into the laws that read a stem: √Y from the frequency, β from the decay.
#pragma once

#include "reduce/histogram.hpp"
#include "reduce/interaction_model.hpp"
#include "reduce/linear_regression.hpp"

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace culm::reduce {

/// The computed points of a study; four spans of one length.
struct StudyPoints {
    std::span<const double> bond_youngs_modulus; ///< Y, Pa
    std::span<const double> bond_damping;        ///< β
    std::span<const double> decay_per_cycle;     ///< fitted b1 in normalised time
    std::span<const double> frequency;           ///< fitted b2, Hz
};

/// Residuals, observed − fitted, in per cent of the largest observed response (Fig. 8).
struct ResidualSummary {
    std::vector<double> percent; ///< (points)
    Histogram histogram;         ///< of `percent`
};

/// response = intercept + slope · predictor: Eq. 12 or 13 of Schramm et al. (2019).
struct SinglePredictorLaw {
    Term predictor = Term::First; ///< First: decay per cycle; Second: frequency
    Coefficient intercept;
    Coefficient slope;
    LinearRegression regression; ///< adjusted R², sigma, covariance
    ResidualSummary residuals;
};

/// The interaction model of both predictors after the F-tests.
struct ReducedModel {
    InteractionModel model;
    NestedTest single_predictor_against_full; ///< p < 0.05: the single-predictor law is rejected
    ResidualSummary residuals;
};

/// Everything learned about one response.
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

/// Closed range of a predictor over the points used.
struct PredictorRange {
    double lowest = 0.0;
    double highest = 0.0;
    [[nodiscard]] bool contains(double x) const { return x >= lowest && x <= highest; }
};

struct StudyRegression {
    std::size_t points_used = 0;
    std::size_t points_excluded = 0;       ///< a value was not finite or Y was not positive
    RegressionOutcome sqrt_youngs_modulus; ///< √Y in √Pa; single law on the frequency (Eq. 12)
    RegressionOutcome bond_damping;        ///< β; single law on the decay per cycle (Eq. 13)
    PredictorRange decay_per_cycle;
    PredictorRange frequency; ///< Hz
};

/// Names of the predictors as they appear in terms and coefficients.
inline constexpr const char* decay_predictor_name = "decay_per_cycle";
inline constexpr const char* frequency_predictor_name = "frequency";

/// Regresses √Y and β on the fitted decay per cycle and frequency, each by its single-predictor law
/// and by the full interaction model reduced with nested F-tests at `significance`. Designs that
/// cannot tell a law give a reason instead of it: fewer than 3 usable points, one value only of the
/// response or of its predictor. Throws core::NumericalError (FitFailed) only if the spans differ
/// in length or significance is not in (0, 1).
[[nodiscard]] StudyRegression regress_study(const StudyPoints& points, double significance = 0.05);

} // namespace culm::reduce
