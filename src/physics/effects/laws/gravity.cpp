// SPDX-License-Identifier: BSD-3-Clause
// The stem's weight.
#include "core/error.hpp"
#include "physics/effects/effect.hpp"

#include <fmt/format.h>

namespace culm::physics {

namespace {

void apply_gravity(std::span<const double> values, EffectTarget& target) {
    if (target.stem.axial_acceleration_of_gravity != 0.0)
        throw core::InputError(fmt::format(
            "gravity is given twice: by the effect and as the stem's own axial acceleration ({} "
            "m/s²); leave one of them out",
            target.stem.axial_acceleration_of_gravity));
    target.model.gravity[0] = values[0];
    target.model.gravity[1] = values[1];
}

EffectParameter acceleration(const char* name, const char* meaning, double standard,
                             StatedBy stated_by) {
    return {.name = name,
            .unit = "m/s²",
            .meaning = meaning,
            .default_value = standard,
            .lower = -200.0,
            .upper = 200.0,
            .scale = 1.0,
            .calibrated = false,
            .stated_by = stated_by};
}

} // namespace

EffectPointer gravity() {
    return make_effect(
        {.name = "gravity",
         .family = Family::Weight,
         .summary = "the weight of the stem and of what it carries",
         .law = "every mass m feels m (g_axial, g_transverse)",
         .source = "Naguleswaran (1991), J. Sound Vib. 146:191-198 (vertical cantilever)",
         .signature =
             "axial: a frequency lower when upright and higher when hanging, by a share "
             "that grows as L³; transverse: a constant sag toward the ground. Straw of 0.2 "
             "m: -0.03 % or 0.1 mm",
         .remedy =
             "the direction is known, so nothing is fitted: state it in the measurement; turn "
             "the set-up over to see it",
         .energy = "stores -m (g_axial x + g_transverse y) per mass. Conservative",
         .parameters = {acceleration("axial_m_s2",
                                     "g_axial: along the stem, positive away from the clamp; -9.81 "
                                     "for a stem that stands upright",
                                     -9.81, StatedBy::AxialGravity),
                        acceleration("transverse_m_s2",
                                     "g_transverse: positive toward the side of the pull", 0.0,
                                     StatedBy::TransverseGravity)}},
        apply_gravity);
}

} // namespace culm::physics
