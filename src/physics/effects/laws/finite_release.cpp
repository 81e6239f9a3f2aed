// SPDX-License-Identifier: BSD-3-Clause
// The finger lets go over some milliseconds.
#include "physics/effects/effect.hpp"
#include "physics/effects/stem_scales.hpp"

#include <algorithm>

namespace culm::physics {

EffectPointer finite_release() {
    return make_effect(
        {.name = "finite_release",
         .family = Family::Release,
         .summary = "the finger lets go over some milliseconds",
         .law = "the holding force at the tip falls as F (1 - 3u² + 2u³), u = t/T from 0 to 1",
         .source = "the lowest polynomial that starts and ends smoothly; cf. the rise time of a "
                   "step load, Clough & Penzien (1993), Dynamics of Structures",
         .signature = "mode 2 is weaker than the model says, in the first milliseconds only, and "
                      "the swing starts late by about half the duration",
         .remedy = "burn or cut a thread instead of letting go; or fit from a later frame",
         .energy =
             "the finger still does work while it lets go: F (1 - 3u² + 2u³) times the tip's "
             "speed, which takes energy out, for the tip moves against its force. After T: none",
         .parameters = {size_parameter(
             "duration_s", "s", "T: from the first to the last of the finger's force",
             {.default_value = 2e-3, .lower = 1e-6, .upper = 10.0, .scale = 1e-3})},
         .belongs_to = BelongsTo::Recording,
         .is_of_the_release = true},
        [](std::span<const double> values, EffectTarget& target) {
            // The holding force is known once the stem has been deflected.
            target.model.release = GradualRelease<double>{values[0], 0.0};
        },
        [](const StemParameters<double>& stem, std::span<EffectParameter> parameters) {
            const double period = 1.0 / first_frequency(stem);
            EffectParameter& duration = parameters[0];
            duration.default_value = std::max(duration.lower, 0.1 * period);
            duration.scale = duration.default_value;
            // A finger that takes more than a period leads the stem back and releases nothing.
            duration.upper = std::min(duration.upper, std::max(period, 2.0 * duration.lower));
        });
}

} // namespace culm::physics
