// SPDX-License-Identifier: BSD-3-Clause
// Where the fit of a model with effects begins.
#pragma once

#include "fit/solve/fit.hpp"
#include "integrate/linearised.hpp"
#include "integrate/modes.hpp"

#include <string>
#include <vector>

namespace culm::fit {

/// Frequencies (Hz) at which the residuals of a fit are strongest, at most `count`.
[[nodiscard]] std::vector<double> residual_peaks(const RecordingFit& fit, std::size_t count);

/// The value of a size at which its effect is absent, within the bounds.
[[nodiscard]] double absent_value(const FreeParameter& parameter);

/// The scales of a stem in a recording of this duration (s), without peaks of residuals.
[[nodiscard]] physics::StartScales stem_start_scales(const physics::StemParameters<double>& stem,
                                                     double duration);

/// Changes Y and β until the first mode of `start` has the frequency and decay of `wanted`.
void keep_first_mode(const integrate::VibrationMode& wanted, StemModel& start);

enum class StartSize {
    Absent, ///< the fit of the smaller model is the start; no derivative leads away from it for
            ///< effects whose first order vanishes
    Default
};

/// Starts for a fit of `model` that contains what `smaller` was fitted with. Values of parameters
/// that both have come from `smaller`. Places, angles and time scales of the others start from
/// several values each, sizes as `size` says. In every start Y and β are changed so that the first
/// mode keeps its frequency and decay: what shifts the frequency would otherwise begin cycles away.
/// A stem that leaves the plane starts from the beats that the readings show (recorded_beats()), if
/// they show any.
[[nodiscard]] std::vector<StemModel> fit_starts(const StemModel& model, const RecordingFit& smaller,
                                                StartSize size);

/// Does the fit of `model` have to begin with sizes of its own, because none leads there from where
/// its effects are absent?
[[nodiscard]] bool has_own_sizes(const StemModel& model, const RecordingFit& smaller);

/// Those with the effects absent; without places to choose from there is room for a start with the
/// usual sizes too.
[[nodiscard]] std::vector<StemModel> candidate_starts(const StemModel& model,
                                                      const RecordingFit& smaller);

} // namespace culm::fit
