// SPDX-License-Identifier: BSD-3-Clause
// Calibration of one measured stem: the fitted chain and its adequacy.
#pragma once

#include "diagnose/adequacy.hpp"
#include "fit/solve/uncertainty_budget.hpp"
#include "integrate/modes.hpp"
#include "physics/effects/selection.hpp"

#include <string>
#include <vector>

namespace culm::calibrate {

struct CalibrationOptions {
    fit::FitOptions fit;
    /// Known physics in addition to the baseline; parameters that are not fixed are fitted too.
    std::vector<physics::SelectedEffect> effects;
};

struct Calibration {
    std::string id;
    measure::MeasuredStem stem;
    fit::Fit fit;
    fit::UncertaintyBudget budget; ///< of the fit's parameters, in their order

    [[nodiscard]] const fit::RecordingFit& part() const { return fit.parts.front(); }
    integrate::VibrationMode mode; ///< the first of the chain without effects
    reduce::Estimate frequency;    ///< of that mode, Hz
    reduce::Estimate decay_per_cycle;
    double damping_time = 0.0; ///< τ of M = E I (κ + τ κ̇), s
    /// Relative error of Y because still air moves with the stem; 0 if the model has that air.
    double still_air_bias = 0.0;
    diagnose::Verdict verdict;
};

/// The last model of fit_nested(), as `culm compare --with` fits it. Throws core::InputError if the
/// measurement cannot be such a model, core::NumericalError if the fit fails or ends at a
/// bound, where its values are not a calibration.
[[nodiscard]] Calibration calibrate_stem(const measure::Measurement& measurement,
                                         const CalibrationOptions& options = {});

} // namespace culm::calibrate
