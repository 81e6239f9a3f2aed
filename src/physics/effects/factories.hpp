// SPDX-License-Identifier: BSD-3-Clause
// The effects of the library, one source file each; library.hpp gives them by name.
#pragma once

#include "physics/effects/effect.hpp"

namespace culm::physics {

// The stem
[[nodiscard]] EffectPointer taper();
[[nodiscard]] EffectPointer stiffness_gradient();
[[nodiscard]] EffectPointer local_defect();
[[nodiscard]] EffectPointer precurvature();
[[nodiscard]] EffectPointer out_of_plane();
[[nodiscard]] EffectPointer bending_nonlinearity();
[[nodiscard]] EffectPointer hysteretic_damping();
[[nodiscard]] EffectPointer relaxation();
// The clamp
[[nodiscard]] EffectPointer clamp_compliance();
[[nodiscard]] EffectPointer clamp_friction();
[[nodiscard]] EffectPointer base_motion();
// What acts on the stem from outside
[[nodiscard]] EffectPointer gravity();
[[nodiscard]] EffectPointer tip_mass();
[[nodiscard]] EffectPointer quadratic_drag();
[[nodiscard]] EffectPointer viscous_drag();
// The release
[[nodiscard]] EffectPointer finite_release();
// The camera
[[nodiscard]] EffectPointer rolling_shutter();
[[nodiscard]] EffectPointer camera_tilt();

} // namespace culm::physics
