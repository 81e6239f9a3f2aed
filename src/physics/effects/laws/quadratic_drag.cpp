// SPDX-License-Identifier: BSD-3-Clause
// Drag of the air that grows with the square of the speed.
#include "physics/air_drag.hpp"
#include "physics/effects/effect.hpp"

namespace culm::physics {

namespace {

/// r = c |v|.
struct QuadraticLaw {
    template <class T>
    static Resistance<T> at(const T& coefficient, const T& speed, std::span<const T> /*shape*/) {
        return {coefficient * speed, coefficient};
    }
};

} // namespace

EffectPointer quadratic_drag() {
    return make_effect(
        {.name = "quadratic_drag",
         .family = Family::Air,
         .summary = "air drag that grows with the square of the speed",
         .law = "force per length -½ ρ C_d d |v| v, with the whole velocity v of the stem, ρ = 1.2 "
                "kg/m³ and the width d of the section across the motion (of a round stem its outer "
                "diameter) at mid-length",
         .source = "Morison et al. (1950), Petrol. Trans. AIME 189:149-154; C_d of cylinders: "
                   "Hoerner (1965), Fluid-Dynamic Drag; decay: Nayfeh & Mook (1979)",
         .signature = "the decay is faster at large amplitude, 1/A grows linearly in time; the "
                      "residual has the shape of mode 1, a quarter cycle off, and changes sign "
                      "between early and late",
         .remedy = "release from amplitudes 10:1 apart, in vacuum, or with a paper fin at the tip; "
                   "take the drag out of β before it goes into a bulk simulation",
         .energy = "takes out ½ ρ C_d d |v|³ per length and second. Gives nothing back",
         .parameters = {size_parameter(
             "drag_coefficient", "",
             "C_d: about 1.2 for a smooth cylinder in steady flow, more in a swing of few "
             "diameters",
             {.default_value = 1.2, .lower = 0.0, .upper = 100.0, .scale = 1.0})},
         .belongs_to = BelongsTo::Rig,
         .revealed_by = {{"release in a vacuum", {0.0}}}},
        [](std::span<const double> values, EffectTarget& target) {
            target.model.air.push_back(
                {.law = &resistance_law<QuadraticLaw>,
                 .coefficient = 0.5 * air_density * values[0] * target.stem.width_in_air()});
        });
}

} // namespace culm::physics
