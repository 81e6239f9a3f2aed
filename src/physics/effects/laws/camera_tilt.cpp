// SPDX-License-Identifier: BSD-3-Clause
// The camera looks at the stem at an angle: its scale changes with height.
#include "physics/effects/effect.hpp"

namespace culm::physics {

EffectPointer camera_tilt() {
    return make_effect(
        {.name = "camera_tilt",
         .family = Family::SupportAndCamera,
         .summary = "the camera looks at an angle: its scale changes with height",
         .law = "a deflection at height h is read as y (1 + e h/L)",
         .source = "Hartley & Zisserman (2004), Multiple View Geometry, Cambridge (perspective, to "
                   "first order)",
         .signature =
             "a mode shape stretched toward the tip at every frequency and amplitude alike; "
             "resembles a gradient of stiffness",
         .remedy =
             "film a grid or two scale bars, one at the clamp and one at the tip, and set the "
             "camera upright",
         .energy = "none: the camera does not touch the stem",
         .parameters = {size_parameter(
             "scale_change", "", "e: share by which the tip's row is read too large",
             {.default_value = 0.02, .lower = -0.5, .upper = 0.5, .scale = 0.01})},
         .belongs_to = BelongsTo::Rig},
        [](std::span<const double> values, EffectTarget& target) {
            target.camera.scale_change = values[0];
        });
}

} // namespace culm::physics
