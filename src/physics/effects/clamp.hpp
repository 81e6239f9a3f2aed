// SPDX-License-Identifier: BSD-3-Clause
// Parameters that the effects of a yielding clamp share.
#pragma once

#include "physics/effects/effect.hpp"

namespace culm::physics {

/// Stiffness of the clamp's rotational spring.
[[nodiscard]] EffectParameter clamp_stiffness();

/// Rate at which dry friction is three quarters of its full moment. Fixed: it only regularises.
[[nodiscard]] EffectParameter clamp_friction_rate();

/// A clamp that lowers the frequencies by some 4 % is a common one; one a thousand times softer
/// does not hold the stem, and one a thousand times stiffer cannot be told from a rigid one.
void suit_clamp_stiffness(const StemParameters<double>& stem, EffectParameter& stiffness);

} // namespace culm::physics
