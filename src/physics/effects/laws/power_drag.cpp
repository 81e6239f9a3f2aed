// SPDX-License-Identifier: BSD-3-Clause
// Drag of the air that grows with a power of the speed between one and two.
#include "physics/effects/air.hpp"
#include "physics/effects/effect.hpp"

namespace culm::physics {

namespace {

constexpr double reference_speed = 1.0; // m/s: there C is the coefficient of quadratic drag

} // namespace

EffectPointer power_drag() {
    return make_effect(
        {.name = "power_drag",
         .family = Family::Air,
         .summary = "air drag that grows with a power of the speed between one and two",
         .law =
             "force per length -½ ρ C d v_r² (|v|/v_r)^p v/|v|, with the whole velocity v of the "
             "stem, ρ = 1.2 kg/m³, v_r = 1 m/s and the width d of the section across the "
             "motion. p = 1 is viscous_drag with c = ½ ρ C d v_r, p = 2 quadratic_drag with C_d "
             "= C",
         .source = "plates that swing by a few widths: C_d = 8 KC^(-1/3), so p = 5/3: Graham "
                   "(1980), J. Fluid Mech. 97:331-346; decay: Nayfeh & Mook (1979)",
         .signature = "the decay rate grows with the amplitude as A^(p - 1): between air drag that "
                      "does not depend on it and quadratic drag",
         .remedy = "release from amplitudes 10:1 apart, or in vacuum; one amplitude gives C at the "
                   "stem's speed, not p",
         .energy = "takes out ½ ρ C d v_r³ (|v|/v_r)^(p + 1) per length and second. Gives nothing "
                   "back",
         .parameters =
             {size_parameter("drag_coefficient", "",
                             "C: coefficient of the quadratic drag with the same force at 1 m/s",
                             {.default_value = 1.2, .lower = 0.0, .upper = 100.0, .scale = 1.0}),
              place_parameter("exponent", "",
                              "p: 1 at low Reynolds numbers, 2 where the flow separates at an edge",
                              {.default_value = 1.5, .lower = 0.8, .upper = 2.4, .scale = 0.5},
                              [](const StartScales& /*of*/) {
                                  return std::vector{1.2, 1.8};
                              })},
         .belongs_to = BelongsTo::Rig,
         .revealed_by = {{"release in a vacuum", {0.0, 1.0}}}},
        [](std::span<const double> values, EffectTarget& target) {
            target.model.air.push_back({.law = &resistance_law<PowerLaw>,
                                        .coefficient = 0.5 * air_density * values[0] *
                                                       target.stem.width_in_air() * reference_speed,
                                        .shape = {values[1]}});
        });
}

} // namespace culm::physics
