// SPDX-License-Identifier: BSD-3-Clause
// The camera reads its rows one after the other.
#include "physics/effects/effect.hpp"

namespace culm::physics {

EffectPointer rolling_shutter() {
    return make_effect(
        {.name = "rolling_shutter",
         .family = Family::SupportAndCamera,
         .summary = "the camera reads its rows one after the other",
         .law =
             "the row at height h is read at t + T h/L: the tip's row later than the clamp's by T",
         .source = "Ait-Aider, Andreff, Lavest & Martinet (2006), ECCV, LNCS 3952:56-68",
         .signature = "a residual a quarter cycle off that grows with height times speed, all "
                      "through the record; a phase that changes along the stem",
         .remedy = "use a global shutter, or turn the camera so that its rows run along the stem",
         .energy = "none: the camera does not touch the stem",
         .parameters = {size_parameter(
             "readout_s", "s",
             "T: from the row at the clamp to the row at the tip's height, in addition to "
             "row_time_us; negative if read downward",
             {.default_value = 1e-4, .lower = -0.1, .upper = 0.1, .scale = 1e-4})},
         .belongs_to = BelongsTo::Rig,
         .is_of_the_camera = true},
        [](std::span<const double> values, EffectTarget& target) {
            target.camera.readout_time += values[0];
        });
}

} // namespace culm::physics
