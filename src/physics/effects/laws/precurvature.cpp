// SPDX-License-Identifier: BSD-3-Clause
// The stem is not straight at rest.
#include "physics/effects/effect.hpp"

#include <algorithm>

namespace culm::physics {

namespace {

void apply_precurvature(std::span<const double> values, EffectTarget& target) {
    const StemParameters<double>& stem = target.stem;
    expand_links(target.model, stem.sphere_count);
    const std::vector<BondCoefficients<double>>& bonds = target.model.bonds;
    target.model.straight_moments.resize(bonds.size());
    for (std::size_t j = 0; j < bonds.size(); ++j) {
        const double place = (static_cast<double>(j) + 0.5) / static_cast<double>(bonds.size());
        const double curvature = values[0] + (values[1] - values[0]) * place;
        // The bond's moment while it is straight, −E I κ₀ = −(E I/l) l κ₀.
        target.model.straight_moments[j] =
            -bonds[j].bending_stiffness * bonds[j].length * curvature;
    }
}

EffectParameter curvature(const char* name, const char* place) {
    return {.name = name,
            .unit = "1/m",
            .meaning = std::string("natural curvature at the ") + place +
                       ", positive toward the side of the pull",
            .default_value = 0.1,
            .lower = -100.0,
            .upper = 100.0,
            .scale = 0.1};
}

} // namespace

EffectPointer precurvature() {
    return make_effect(
        {.name = "precurvature",
         .family = Family::StemGeometry,
         .summary = "the stem is curved at rest",
         .law = "M = E I (κ - κ0(s)), κ0 linear from the clamp to the tip",
         .source = "Love (1927), Treatise on the Mathematical Theory of Elasticity, ch. XVIII "
                   "(naturally curved rods)",
         .signature = "a constant offset that grows as the square of the height (uniform κ0); "
                      "frequency and decay stay",
         .remedy = "turn the stem by 180 degrees about its axis: the offset changes sign, that of "
                   "a sideways weight does not",
         .energy =
             "stores ½ E I (κ - κ0)²: the straight stem holds ½ E I κ0² per length. Conservative",
         .parameters = {curvature("base_curvature_1_m", "clamp"),
                        curvature("tip_curvature_1_m", "tip")},
         .revealed_by = {{"turn the stem by 180 degrees about its own axis and release again",
                          {-1.0, -1.0}}},
         .spans_the_stem = true},
        apply_precurvature,
        [](const StemParameters<double>& stem, std::span<EffectParameter> parameters) {
            const double length = stem.free_length();
            for (EffectParameter& curvature : parameters) {
                curvature.lower = std::max(curvature.lower, -1.0 / length);
                curvature.upper = std::min(curvature.upper, 1.0 / length);
                curvature.default_value = 0.02 / length;
                curvature.scale = 0.02 / length;
            }
        });
}

} // namespace culm::physics
