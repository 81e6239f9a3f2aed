// SPDX-License-Identifier: BSD-3-Clause
// Inner friction whose loss factor grows with the strain.
#include "physics/effects/effect.hpp"
#include "physics/effects/stem_scales.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace culm::physics {

EffectPointer amplitude_damping() {
    return make_effect(
        {.name = "amplitude_damping",
         .family = Family::MaterialDamping,
         .summary = "inner friction that grows with the strain",
         .law = "M = E I (κ + δ (|κ|/κ_r)^p dκ/dt) with the curvature κ_r that strains the "
                "outermost fibre by 0.001, and δ such that a cycle of mode 1 of the strain ε "
                "loses π η (ε/0.001)^p E I κ² per length",
         .source = "Lazan (1968), Damping of Materials and Members in Structural Mechanics, "
                   "Pergamon (loss ~ stress^(2 + p))",
         .signature = "the damping ratio grows with the amplitude as A^p and the frequency stays; "
                      "the loss sits where the stem bends, near the clamp",
         .remedy = "release from amplitudes 10:1 apart, and in vacuum, which leaves this loss and "
                   "removes that of the air",
         .energy = "takes out E I δ (|κ|/κ_r)^p (dκ/dt)² per length and second. Gives nothing back",
         .parameters = {size_parameter(
                            "loss_factor", "", "η: loss factor at a strain of 0.001",
                            {.default_value = 0.01, .lower = 0.0, .upper = 1e3, .scale = 0.01}),
                        place_parameter(
                            "exponent", "", "p: 0 is a loss that does not depend on the amplitude",
                            {.default_value = 1.0, .lower = 0.3, .upper = 3.0, .scale = 0.5},
                            [](const StartScales& /*of*/) {
                                return std::vector{1.0, 2.0};
                            })}},
        [](std::span<const double> values, EffectTarget& target) {
            const double power = values[1];
            // ∮ |sin|^p cos².
            const double mean = std::sqrt(std::numbers::pi) * std::tgamma(0.5 * (power + 1.0)) /
                                std::tgamma(0.5 * power + 2.0);
            target.model.bending_loss = BendingLoss<double>{
                .time = std::numbers::pi * values[0] / (loaded_angular_frequency(target) * mean),
                .power = power,
                .curvature = reference_strain / target.stem.outer_fibre()};
        },
        // A loss factor of 0.01 when the stem is pulled aside by a tenth of its length.
        [](const StemParameters<double>& stem, std::span<EffectParameter> parameters) {
            EffectParameter& loss = parameters[0];
            loss.default_value =
                std::min(0.01 * reference_strain / pulled_strain(stem), 0.1 * loss.upper);
            loss.scale = loss.default_value;
        });
}

} // namespace culm::physics
