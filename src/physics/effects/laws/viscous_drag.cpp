// SPDX-License-Identifier: BSD-3-Clause
// Drag of the air in proportion to the speed.
#include "physics/air_drag.hpp"
#include "physics/effects/effect.hpp"
#include "physics/effects/stem_scales.hpp"

#include <algorithm>
#include <numbers>

namespace culm::physics {

namespace {

/// r = c.
struct ViscousLaw {
    template <class T>
    static Resistance<T> at(const T& coefficient, const T& /*speed*/,
                            std::span<const T> /*shape*/) {
        return {coefficient, T(0.0)};
    }
};

} // namespace

EffectPointer viscous_drag() {
    return make_effect(
        {.name = "viscous_drag",
         .family = Family::Air,
         .summary = "air drag in proportion to the speed",
         .law = "force per length -c v, with the whole velocity v of the stem",
         .source = "Stokes (1851), Trans. Camb. Phil. Soc. 9:8-106 (cylinders that swing in a "
                   "fluid)",
         .signature = "a damping ratio that falls with frequency as 1/f, at every amplitude alike; "
                      "with one visible mode it is indistinguishable from the bonds' damping",
         .remedy = "repeat in vacuum, or with at least three frequencies (mass at the tip, shorter "
                   "length)",
         .energy = "takes out c v² per length and second. Gives nothing back",
         .parameters = {size_parameter(
             "coefficient_n_s_m2", "N s/m²", "c: force per length over speed",
             {.default_value = 1e-3, .lower = 0.0, .upper = 1e3, .scale = 1e-3})},
         .belongs_to = BelongsTo::Rig,
         .revealed_by = {{"release in a vacuum", {0.0}}}},
        [](std::span<const double> values, EffectTarget& target) {
            target.model.air.push_back(
                {.law = &resistance_law<ViscousLaw>, .coefficient = values[0]});
        },
        // Damping ratio ζ of mode 1 is c/(2 m' ω1): 0.2 % is that of a straw in air.
        [](const StemParameters<double>& stem, std::span<EffectParameter> parameters) {
            const double critical =
                4.0 * std::numbers::pi * mass_per_length(stem) * first_frequency(stem);
            EffectParameter& coefficient = parameters[0];
            coefficient.default_value = 0.002 * critical;
            coefficient.scale = 0.002 * critical;
            coefficient.upper = std::min(coefficient.upper, critical);
        });
}

} // namespace culm::physics
