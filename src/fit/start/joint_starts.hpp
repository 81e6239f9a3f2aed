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

/// How a recording swings, whatever the model: Eq. 1 fitted to it.
struct RecordedSwing {
    integrate::VibrationMode mode{}; ///< damped
    double cycles = 0.0;             ///< until its end
    double tip_deflection = 0.0;     ///< of its baseline model's start, m
};

[[nodiscard]] RecordedSwing recorded_swing(const measure::Measurement& measurement,
                                           const FitOptions& options);

/// Models where the posteriors of their own fits, `alone`, meet, and, where the recordings' first
/// modes would differ from their swings by a different share, or a fit has no covariance, with the
/// shared values of each recording too.
[[nodiscard]] std::vector<StartModels> shared_starts(const StartModels& models,
                                                     std::span<const RecordingFit> alone,
                                                     std::span<const RecordedSwing> swings,
                                                     const JointLayout& layout);

/// Where one material does not give all recordings their frequencies, a size that `smaller` does
/// not have may: the mass that each recording needs beside the modulus of the stiffest one, or the
/// compliance that makes their moduli one. Such starts, made of `models` by the linearised chain;
/// none if the recordings agree already, or no new size reconciles them.
[[nodiscard]] std::vector<StartModels> reconciling_starts(const StartModels& models,
                                                          std::span<const RecordingFit> smaller,
                                                          std::span<const RecordedSwing> swings);

} // namespace culm::fit
