// SPDX-License-Identifier: BSD-3-Clause
// Where the fit of one model to several recordings begins.
#pragma once

#include "fit/solve/fit.hpp"
#include "fit/solve/layout.hpp"
#include "integrate/linearised.hpp"
#include "integrate/modes.hpp"

#include <span>
#include <vector>

namespace culm::fit {

/// The swing of a recording from a fit of Eq. 1, independent of a model.
struct RecordedSwing {
    integrate::VibrationMode mode{}; ///< damped
    double cycles = 0.0;             ///< until its end
    double tip_deflection = 0.0;     ///< of its baseline model's start, m
};

[[nodiscard]] RecordedSwing recorded_swing(const measure::Measurement& measurement,
                                           const FitOptions& options);

/// Models at the point where the posteriors of the recordings' own fits, `alone`, meet. If their
/// first modes differ from the recorded swings by different shares, or a fit has no covariance,
/// models with the shared values of each recording are added.
[[nodiscard]] std::vector<StartModels> shared_starts(const StartModels& models,
                                                     std::span<const RecordingFit> alone,
                                                     std::span<const RecordedSwing> swings,
                                                     const JointLayout& layout);

/// If one material does not give all recordings their frequencies, a size that `smaller` does not
/// have may do so: a mass for each recording with the modulus of the stiffest one, or a compliance
/// that makes their moduli equal. Returns such starts, made from `models` by the linearised chain;
/// none if the recordings agree already, or no new size reconciles them.
[[nodiscard]] std::vector<StartModels> reconciling_starts(const StartModels& models,
                                                          std::span<const RecordingFit> smaller,
                                                          std::span<const RecordedSwing> swings);

} // namespace culm::fit
