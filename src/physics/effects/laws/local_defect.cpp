// SPDX-License-Identifier: BSD-3-Clause
// A short weak or stiff segment: a node, a kink, a crack.
#include "physics/effects/effect.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace culm::physics {

namespace {

/// Length of the segment over that of the stem.
constexpr double relative_length = 0.03;

/// Share of a bell curve around zero with standard deviation `spread` that lies below `position`.
double share_below(double position, double spread) {
    return 0.5 * std::erfc(-position / (std::numbers::sqrt2 * spread));
}

void apply_local_defect(std::span<const double> values, EffectTarget& target) {
    const double centre = values[0];
    const double bond = target.stem.bond_length;
    const double segment = relative_length * target.stem.free_length();
    // The extra compliance of the segment is distributed over the bonds as a bell curve with the
    // segment's own standard deviation, so that the response depends smoothly on the position. The
    // deviation is at least half a bond; otherwise a position between the middles of two bonds
    // would have no effect.
    const double spread = std::max(segment / std::sqrt(12.0), 0.5 * bond);
    const double extra_compliance = (1.0 / values[1] - 1.0) * segment / bond;
    change_along_stem(target, [=](StemParameters<double> stem, double position) {
        const double share = share_below(position + 0.5 * bond - centre, spread) -
                             share_below(position - 0.5 * bond - centre, spread);
        stem.bond_youngs_modulus /= 1.0 + extra_compliance * share;
        return stem;
    });
}

} // namespace

EffectPointer local_defect() {
    return make_effect(
        {.name = "local_defect",
         .family = Family::StemGeometry,
         .summary = "a short segment is weaker or stiffer: a node, a kink, a crack",
         .law =
             "over 3 % of the length around s0, Y is multiplied by the factor f; the bonds there "
             "share the compliance (1/f - 1) 0.03 L/(E I) as a bell curve around s0",
         .source = "Dimarogonas (1996), Eng. Fract. Mech. 55:831-857 (a crack as a local "
                   "compliance)",
         .signature = "a kink: the slope of the residual's shape jumps at one height; every mode "
                      "shifts by the square of its curvature there",
         .remedy =
             "film more heights near the kink, or bend the stem between four points; with few "
             "heights stiffness_gradient says nearly the same",
         .energy = "no direct loss: the segment stores ½ f E I κ². Conservative; the damping "
                   "of its bonds falls with their stiffness",
         .parameters =
             {place_parameter(
                  "position_m", "m", "s0: middle of the segment, from the clamp along the stem",
                  {.default_value = 0.05, .lower = 0.0, .upper = 10.0, .scale = 0.02},
                  // Mode 2 does not bend at 0.22 L and bends most at 0.53 L. With fewer starts a
                  // fit ends at a place where a stiff segment changes the modes like a weak one.
                  [](const StartScales& of) {
                      return std::vector{0.05 * of.length, 0.2 * of.length,  0.35 * of.length,
                                         0.5 * of.length,  0.65 * of.length, 0.8 * of.length};
                  }),
              {.name = "stiffness_factor",
               .unit = "",
               .meaning = "f: stiffness of the segment over that of the stem",
               .default_value = 0.7,
               .lower = 0.01,
               .upper = 100.0,
               .scale = 0.3,
               .fitted_as = FittedAs::Logarithm,
               .absent = 1.0}},
         .spans_the_stem = true},
        apply_local_defect,
        [](const StemParameters<double>& stem, std::span<EffectParameter> parameters) {
            const double length = stem.free_length();
            EffectParameter& position = parameters[0];
            position.upper = std::min(position.upper, length);
            position.default_value = 0.3 * length;
            position.scale = 0.1 * length;
        });
}

} // namespace culm::physics
