// SPDX-License-Identifier: BSD-3-Clause
// Calibration of recordings on one rig: the effects of the rig have one value for all of them.
#pragma once

#include "calibrate/calibration.hpp"
#include "core/item_map.hpp"
#include "diagnose/diagnosis.hpp"

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace culm::calibrate {

/// The effects of rigs with several recordings.
struct SharedEffects {
    std::vector<diagnose::EffectAnswer> effects; ///< fitted, with their values
    std::vector<diagnose::StemAnswer> stems; ///< (specimens) of the joint fit; empty without one
};

/// Fits the effects of rigs that `effects` names, with one value of each free parameter for all
/// recordings on a rig (docs/laboratory.md); the stems' own numbers and effects are fitted
/// with them. Computes nothing if no two recordings share a rig, or if no parameter is free.
/// Collective if `map` is. Throws core::NumericalError if the models cannot be fitted.
[[nodiscard]] SharedEffects
fit_shared_effects(std::span<const measure::Measurement> measurements,
                   const CalibrationOptions& options, const core::ItemMap& map,
                   const std::function<void(const std::string&)>& progress);

/// The options with the shared values fixed.
[[nodiscard]] CalibrationOptions with_shared_values(const CalibrationOptions& options,
                                                    const SharedEffects& shared,
                                                    const measure::Measurement& measurement);

/// Adds the uncertainty of the shared values to the calibration, as a line of its budget.
void add_shared_uncertainty(const SharedEffects& shared, const measure::Measurement& measurement,
                            Calibration& calibration);

} // namespace culm::calibrate
