// SPDX-License-Identifier: BSD-3-Clause
// The clamp yields like a spring.
#include "physics/effects/clamp.hpp"
#include "physics/effects/effect.hpp"

namespace culm::physics {

EffectPointer clamp_compliance() {
    return make_effect(
        {.name = "clamp_compliance",
         .family = Family::Clamp,
         .summary = "the clamp yields: a rotational spring at the base",
         .law =
             "M = -k (θ + η/ω1 dθ/dt) on the stem's first cross-section, with its rotation θ and "
             "the angular frequency ω1 of mode 1",
         .source = "Chun (1972), J. Appl. Mech. 39:1154-1155 (beam with one end spring-hinged and "
                   "the other free)",
         .signature =
             "a slope at the clamp: the residual is linear in height near the root; all "
             "frequencies fall by nearly the same share 2 E I/(k L), which a lower modulus "
             "does too",
         .remedy = "film a mark right above the clamp; pull statically and read two heights; clamp "
                   "again. In a model that feeds a bulk simulation keep k out of the modulus",
         .energy = "stores ½ k θ² and takes out π η k θ² in a cycle of mode 1",
         .parameters = {clamp_stiffness(), clamp_loss()},
         .belongs_to = BelongsTo::Rig},
        [](std::span<const double> values, EffectTarget& target) {
            // Without friction its rate has no effect, but it must not be zero.
            target.model.hinge =
                BaseHinge<double>{values[0], 0.0, clamp_friction_rate().default_value,
                                  values[0] * values[1] / loaded_angular_frequency(target)};
        },
        [](const StemParameters<double>& stem, std::span<EffectParameter> parameters) {
            suit_clamp_stiffness(stem, parameters[0]);
        });
}

} // namespace culm::physics
