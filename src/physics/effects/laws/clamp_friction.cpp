// SPDX-License-Identifier: BSD-3-Clause
// Dry friction in a clamp that yields.
#include "physics/effects/clamp.hpp"
#include "physics/effects/effect.hpp"
#include "physics/effects/stem_scales.hpp"

#include <algorithm>

namespace culm::physics {

EffectPointer clamp_friction() {
    return make_effect(
        {.name = "clamp_friction",
         .family = Family::Clamp,
         .summary = "dry friction in a yielding clamp",
         .law = "M = -k θ - M_f tanh(ω/ω_r), with the rotation θ and its rate ω at the clamp; the "
                "hyperbolic tangent replaces the sign of ω, which is undefined at rest",
         .source = "Den Hartog (1931), Trans. ASME 53:107-115 (Coulomb and viscous friction)",
         .signature = "the amplitude falls by the same amount in each cycle, so the decay rate "
                      "grows toward the end; the stem may stop off its centre, elsewhere in each "
                      "release; the residual is linear in height from the root",
         .remedy =
             "tighten or change the clamp and release again; releases of small amplitude show "
             "it best. The spring of clamp_compliance is part of it",
         .energy = "stores ½ k θ² and takes out M_f ω tanh(ω/ω_r) per second: 4 M_f θ in a cycle "
                   "of amplitude θ, whatever its frequency. Gives nothing back",
         .parameters = {size_parameter(
                            "moment_nm", "N m", "M_f: friction moment of the turning clamp",
                            {.default_value = 1e-4, .lower = 0.0, .upper = 1e3, .scale = 1e-4}),
                        clamp_spring(), clamp_friction_rate()},
         .excludes = {"clamp_compliance"},
         .belongs_to = BelongsTo::Rig},
        [](std::span<const double> values, EffectTarget& target) {
            target.model.hinge = BaseHinge<double>{values[1], values[0], values[2]};
        },
        [](const StemParameters<double>& stem, std::span<EffectParameter> parameters) {
            // A hundredth of the root's moment when the tip is pulled aside by a tenth of the
            // length.
            const double scale = 0.003 * stiffness_scale(stem);
            EffectParameter& moment = parameters[0];
            moment.default_value = scale;
            moment.scale = scale;
            moment.upper = std::min(moment.upper, 1000.0 * scale);
            suit_clamp_stiffness(stem, parameters[1]);
        });
}

} // namespace culm::physics
