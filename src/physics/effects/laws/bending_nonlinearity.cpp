// SPDX-License-Identifier: BSD-3-Clause
// A bending moment that grows less or more than in proportion to the curvature.
#include "physics/effects/effect.hpp"

#include <algorithm>

namespace culm::physics {

EffectPointer bending_nonlinearity() {
    return make_effect(
        {.name = "bending_nonlinearity",
         .family = Family::StemGeometry,
         .summary = "the bending moment is not proportional to the curvature",
         .law = "M = E I κ (1 + γ κ²); γ < 0: the section flattens and softens",
         .source = "Brazier (1927), Proc. R. Soc. A 116:104-114 (flattening); Nayfeh & Mook "
                   "(1979), Nonlinear Oscillations (backbone curve)",
         .signature = "the frequency depends on the amplitude as A²: the phase drifts early in the "
                      "record, with a third harmonic in phase; the decay stays",
         .remedy = "record a static curve of force against deflection, or release from several "
                   "amplitudes; check the camera's lens, which can feign it",
         .energy = "stores E I (½ κ² + ¼ γ κ⁴) per length. Conservative, as long as 1 + 3 γ κ² > 0",
         .parameters = {size_parameter(
             "gamma_m2", "m²", "γ: negative where the stem softens",
             {.default_value = -0.01, .lower = -10.0, .upper = 10.0, .scale = 0.01})}},
        [](std::span<const double> values, EffectTarget& target) {
            if (!target.model.bending)
                target.model.bending.emplace();
            target.model.bending->cubic = values[0];
        },
        // A stem pulled aside by a tenth of its length L bends at the clamp with 0.3/L.
        [](const StemParameters<double>& stem, std::span<EffectParameter> parameters) {
            const double square = stem.free_length() * stem.free_length();
            EffectParameter& gamma = parameters[0];
            // At this bound 1 + 3 γ κ² reaches zero at the curvature above: the moment would fall
            // while the bend grows.
            gamma.lower = std::max(gamma.lower, -4.0 * square);
            gamma.upper = std::min(gamma.upper, 4.0 * square);
            gamma.default_value = -0.3 * square;
            gamma.scale = 0.3 * square;
        });
}

} // namespace culm::physics
