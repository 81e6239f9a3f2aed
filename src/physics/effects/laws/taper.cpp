// SPDX-License-Identifier: BSD-3-Clause
// The stem's diameter changes linearly from the clamp to the tip.
#include "physics/effects/effect.hpp"

namespace culm::physics {

namespace {

void apply_taper(std::span<const double> values, EffectTarget& target) {
    const double change = values[0];
    const double length = target.stem.free_length();
    change_along_stem(target, [=](StemParameters<double> stem, double position) {
        const double scale = 1.0 + change * (position / length - 0.5);
        stem.bond_outer_diameter *= scale;
        stem.bond_inner_diameter *= scale;
        // The mass per length grows with the section: as the square of the diameter, while a
        // sphere's own mass would grow as its cube.
        stem.sphere_diameter *= scale;
        stem.density /= scale;
        return stem;
    });
}

} // namespace

EffectPointer taper() {
    return make_effect(
        {.name = "taper",
         .family = Family::StemGeometry,
         .summary = "the diameter changes linearly along the stem",
         .law = "d(s) = d [1 + r (s/L - 1/2)], outer and inner alike; m' ~ d², E I ~ d⁴. At "
                "mid-length nothing changes",
         .source = "Mabie & Rogers (1972), J. Acoust. Soc. Am. 51:1771-1774 (double-tapered "
                   "cantilevers)",
         .signature = "a smooth error of the mode shape that changes sign near mid-height, and a "
                      "ratio f2/f1 other than 6.27; frequency and decay do not depend on the "
                      "amplitude. The calibrated modulus takes up most of it: 5 % taper moves it "
                      "by about 10 %",
         .remedy = "measure the diameter at both ends and fix relative_change; or test the stem "
                   "turned end for end",
         .energy = "no direct loss: it changes the energy of a given bend, ½ E I(s) κ², and of "
                   "a given motion, ½ m'(s) v². Conservative",
         .parameters = {size_parameter(
             "relative_change", "",
             "r: diameter at the tip less that at the clamp, over that at mid-length",
             {.default_value = -0.1, .lower = -1.0, .upper = 1.0, .scale = 0.1})},
         .spans_the_stem = true},
        apply_taper);
}

} // namespace culm::physics
