// SPDX-License-Identifier: BSD-3-Clause
// A physical effect added to a model of a measured stem, its parameters free or fixed.
#pragma once

#include "calibrate/stem_model.hpp"
#include "measure/folder/measurement.hpp"
#include "physics/effects/selection.hpp"

namespace culm::calibrate {

/// The number `parameter` of the effect of that name in a case, called "effect.parameter", with the
/// bounds and the scale that suit the stem: those for any stem span so many decades that a value
/// which is small for all of them would count as lying at a bound. The case must contain the effect
/// when it is read or set.
[[nodiscard]] FreeParameter effect_parameter(const physics::Effect& effect,
                                             const physics::StemParameters<double>& stem,
                                             std::size_t parameter);

/// Appends the effect to the model's case with the user's fixed values and, for the rest, the
/// defaults that suit the stem; parameters that are calibrated and not fixed become free. What
/// the measurement states (direction of gravity, time of the hold) comes from it where the user
/// does not fix it. Throws core::InputError if the effects cannot be combined, or gravity has no
/// direction.
[[nodiscard]] StemModel with_effect(StemModel model, const physics::SelectedEffect& selected,
                                    const measure::Measurement& measurement);

} // namespace culm::calibrate
