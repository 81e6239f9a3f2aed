// SPDX-License-Identifier: BSD-3-Clause
// A clamp that slips a little: it softens and damps more the higher its moment.
#include "physics/effects/clamp.hpp"
#include "physics/effects/effect.hpp"
#include "physics/effects/stem_scales.hpp"

#include <algorithm>
#include <cmath>

namespace culm::physics {

EffectPointer clamp_slip() {
    return make_effect(
        {.name = "clamp_slip",
         .family = Family::Clamp,
         .summary = "micro-slip in the clamp, which softens as it damps",
         .law = "moment -z on the stem's first cross-section, dz/dt = k ω (1 - s (|z|/M_r)^n) "
                "while |z| grows and k ω while it falls, with the rate ω at the clamp and the "
                "moment M_r that strains the stem by 0.001",
         .source = "Bouc (1967), Proc. 4th Conf. Nonlinear Oscillations, Prague; Wen (1976), J. "
                   "Eng. Mech. Div. ASCE 102:249-263",
         .signature = "the damping ratio grows with the amplitude as A^n and the frequency falls "
                      "as A^n, both by the share of the clamp; the residual is linear in height "
                      "from the root",
         .remedy = "tighten the clamp or glue the stem, and release again; releases of small "
                   "amplitude do not slip. The spring of clamp_compliance is part of it",
         .energy = "stores z²/2k and takes out z ω s (|z|/M_r)^n per second while |z| grows: 2 s "
                   "z²/((n + 2) k) (z/M_r)^n in a cycle of small slip. Gives nothing back",
         .parameters =
             {size_parameter("slip_share", "",
                             "s: share of the stiffness lost at the moment that strains the stem "
                             "by 0.001",
                             {.default_value = 0.05, .lower = 0.0, .upper = 1e3, .scale = 0.05}),
              clamp_spring(),
              place_parameter("exponent", "", "n: 1 where the slipping area grows with the moment",
                              {.default_value = 1.0, .lower = 0.4, .upper = 2.5, .scale = 0.5},
                              [](const StartScales& /*of*/) { return std::vector{1.0}; })},
         .excludes = {"clamp_compliance", "clamp_friction"},
         .belongs_to = BelongsTo::Rig},
        [](std::span<const double> values, EffectTarget& target) {
            const double reference =
                bending_rigidity(target.stem) * reference_strain / target.stem.outer_fibre(); // N m
            target.model.hinge =
                BaseHinge<double>{values[1], 0.0, clamp_friction_rate().default_value};
            target.model.slip =
                JointSlip<double>{values[0] * std::pow(reference, -values[2]), values[2]};
        },
        // A twentieth when the tip is pulled aside by a tenth of the length.
        [](const StemParameters<double>& stem, std::span<EffectParameter> parameters) {
            EffectParameter& share = parameters[0];
            share.default_value =
                std::min(0.05 * reference_strain / pulled_strain(stem), 0.1 * share.upper);
            share.scale = share.default_value;
            suit_clamp_stiffness(stem, parameters[1]);
        });
}

} // namespace culm::physics
