// SPDX-License-Identifier: BSD-3-Clause
// The inverse use of a study's regressions: Y and β of a stem from its measured decay and
// frequency.
#pragma once

#include "reduce/linear_regression.hpp"
#include "reduce/study_regression.hpp"

#include <optional>
#include <string>

namespace culm::reduce {

/// What Eq. 1 found for a stem. Standard errors of 0 mean that the reading is taken as exact.
struct StemReading {
    double decay_per_cycle = 0.0;
    double frequency = 0.0; ///< Hz
    double decay_per_cycle_standard_error = 0.0;
    double frequency_standard_error = 0.0; ///< Hz
};

/// One parameter of the stem by both laws; a law that the study could not give is empty.
struct ParameterPrediction {
    std::optional<Prediction> by_single_law;
    std::optional<Prediction> by_reduced_model;
    std::string reason; ///< one sentence if any of the two is empty
};

struct StemPrediction {
    ParameterPrediction bond_youngs_modulus; ///< Y, Pa
    ParameterPrediction bond_damping;        ///< β
    bool is_inside_design = false;           ///< both readings lie within what the study covered
};

/// Y and β of a stem by the single-predictor laws (Eqs. 12 and 13) and by the reduced interaction
/// models. The standard errors hold the uncertainty of the coefficients, the scatter of the study
/// (in Prediction::standard_error) and the reading's own errors through the slopes of the law,
/// taken as independent. Y is the square of the predicted √Y: its standard errors are
/// 2√Y times those of √Y, its interval the square of that of √Y.
/// A law that gives √Y <= 0 is left empty with a reason. Throws core::NumericalError (FitFailed) if
/// the reading is not finite.
[[nodiscard]] StemPrediction predict_stem(const StudyRegression& study, const StemReading& reading);

} // namespace culm::reduce
