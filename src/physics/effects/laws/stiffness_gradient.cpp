// SPDX-License-Identifier: BSD-3-Clause
// Young's modulus changes linearly from the clamp to the tip.
#include "physics/effects/effect.hpp"

namespace culm::physics {

EffectPointer stiffness_gradient() {
    return make_effect(
        {.name = "stiffness_gradient",
         .family = Family::StemGeometry,
         .summary = "the modulus changes linearly along the stem",
         .law = "Y(s) = Y [1 + r (s/L - 1/2)]; at mid-length nothing changes",
         .source = "Elishakoff (2005), Eigenvalues of Inhomogeneous Structures, CRC Press",
         .signature = "as taper, but smaller: a smooth error of the mode shape and a ratio f2/f1 "
                      "other than 6.27, at every amplitude alike",
         .remedy = "test the stem turned end for end, or compare the static shape under a known "
                   "force with the model; a camera that looks at an angle says the same "
                   "(camera_tilt)",
         .energy = "no direct loss: it changes the energy of a given bend, ½ Y(s) I κ². "
                   "Conservative; the damping of each bond grows with its stiffness, β stays",
         .parameters = {size_parameter(
             "relative_change", "",
             "r: modulus at the tip less that at the clamp, over that at mid-length",
             {.default_value = -0.2, .lower = -1.9, .upper = 1.9, .scale = 0.1})},
         .spans_the_stem = true},
        [](std::span<const double> values, EffectTarget& target) {
            const double change = values[0];
            const double length = target.stem.free_length();
            change_along_stem(target, [=](StemParameters<double> stem, double position) {
                stem.bond_youngs_modulus *= 1.0 + change * (position / length - 0.5);
                return stem;
            });
        });
}

} // namespace culm::physics
