// SPDX-License-Identifier: BSD-3-Clause
// Y and β of a measured stem by the regressions of a study: Eqs. 12-13 and the F-test terms.
#pragma once

#include "measure/folder/measurement.hpp"
#include "reduce/study_regression.hpp"
#include "run/case_spec.hpp"

#include <optional>
#include <string>
#include <vector>

namespace culm::calibrate {

/// The data of a study that this calibration uses.
struct StudyForCalibration {
    std::string name;                 ///< for messages
    run::CaseSpec base;               ///< stem, law and release of its points
    std::vector<std::string> factors; ///< keys that vary between points besides Y and β
    std::optional<double> window;     ///< of its fits, s; empty: all of `duration`
    reduce::StudyRegression regression;
    core::Interval bond_youngs_modulus; ///< of its points, Pa
    core::Interval bond_damping;
};

struct StudyCalibration {
    double height = 0.0; ///< of the row that was read, m
    double window = 0.0; ///< s: that of the study
    reduce::StemReading reading;
    reduce::StemPrediction prediction; ///< intervals with errors of regression and reading
    std::vector<std::string> warnings; ///< extrapolation, another stem: one sentence each
};

/// Reads b1 and b2 of the highest row that can be fitted, by Eq. 1 with phase 0 over the study's
/// window, as for the study's tips, and inserts them into its regressions. Throws
/// core::NumericalError (FitFailed) if no row can be fitted.
[[nodiscard]] StudyCalibration calibrate_by_study(const measure::Measurement& measurement,
                                                  const StudyForCalibration& study);

} // namespace culm::calibrate
