// SPDX-License-Identifier: BSD-3-Clause
// An ear or a marker at the tip.
#include "physics/effects/effect.hpp"
#include "physics/effects/stem_scales.hpp"

#include <algorithm>

namespace culm::physics {

EffectPointer tip_mass() {
    return make_effect(
        {.name = "tip_mass",
         .family = Family::Weight,
         .summary = "an ear or a marker at the tip",
         .law = "a point mass at the tip's centre; the damping of the stem stays",
         .source = "Laura, Pombo & Susemihl (1974), J. Sound Vib. 37:161-168 (cantilever with a "
                   "mass at the free end)",
         .signature = "all frequencies fall by nearly the same share 2 m/(m' L): nothing that a "
                      "lower modulus would not do; 5 mg on a straw of 80 mg move it by 7 %",
         .remedy = "weigh ear and marker and fix mass_kg; a second release with a known mass "
                   "distinguishes it from clamp and modulus",
         .energy = "holds ½ m v² at the tip. Conservative",
         // A long valley of the objective connects a mass and a stiffer stem.
         .parameters = {size_parameter(
             "mass_kg", "kg", "mass at the tip beyond the stem's own",
             {.default_value = 1e-5, .lower = 0.0, .upper = 10.0, .scale = 1e-5},
             [](const StartScales& of) {
                 return std::vector{0.03 * of.mass, 0.3 * of.mass, 1.5 * of.mass};
             })},
         .belongs_to = BelongsTo::Recording},
        [](std::span<const double> values, EffectTarget& target) {
            target.attached.push_back({target.stem.free_length(), values[0]});
        },
        [](const StemParameters<double>& stem, std::span<EffectParameter> parameters) {
            const double stem_mass = mass_per_length(stem) * stem.free_length();
            EffectParameter& mass = parameters[0];
            mass.default_value = 0.02 * stem_mass;
            mass.scale = 0.02 * stem_mass;
            mass.upper = std::min(mass.upper, 50.0 * stem_mass);
        });
}

} // namespace culm::physics
