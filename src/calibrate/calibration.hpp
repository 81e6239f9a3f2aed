// SPDX-License-Identifier: BSD-3-Clause
// One measured stem calibrated: the fitted chain, what it lacks, and the tests asked for.
#pragma once

#include "calibrate/calibration_check.hpp"
#include "calibrate/profile_likelihood.hpp"
#include "calibrate/study_calibration.hpp"
#include "diagnose/adequacy.hpp"
#include "fit/solve/fit.hpp"
#include "integrate/modes.hpp"
#include "physics/effects/selection.hpp"
#include "run/modes.hpp"

#include <optional>
#include <string>
#include <vector>

namespace culm::calibrate {

struct CalibrationOptions {
    fit::ChainOptions chain;
    fit::SolveOptions fit;
    /// Known physics beside the baseline; parameters that are not fixed are fitted too.
    std::vector<physics::SelectedEffect> effects;
    bool with_profiles = false;
    bool with_check = false;
};

struct Calibration {
    std::string id;
    fit::RecordingFit fit;
    integrate::VibrationMode mode;
    double damping_time = 0.0; ///< τ of M = E I (κ + τ κ̇), s
    diagnose::Verdict verdict;
    std::vector<ProfileInterval> profiles;
    std::optional<CalibrationCheck> check;
    std::string check_failure; ///< why there is no check though one was asked for
};

/// Throws core::InputError if the measurement cannot be such a model, core::NumericalError if the
/// fit cannot start, does not converge or ends at a bound: such values are no calibration.
[[nodiscard]] Calibration calibrate_stem(const measure::Measurement& measurement,
                                         const CalibrationOptions& options = {});

/// The model that calibrate_stem fits.
[[nodiscard]] fit::StemModel model_with_effects(const measure::Measurement& measurement,
                                                const CalibrationOptions& options);

} // namespace culm::calibrate
