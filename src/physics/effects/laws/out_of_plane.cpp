// SPDX-License-Identifier: BSD-3-Clause
// A slightly elliptic section: two planes of bending with different frequencies.
#include "physics/effects/effect.hpp"

#include <cmath>
#include <numbers>

namespace culm::physics {

namespace {

/// Exact for small deflections: bending about one principal axis does not act on the other.
std::vector<PlanarPart> planar_parts(std::span<const double> values) {
    const double angle = values[1] * std::numbers::pi / 180.0;
    const double along = std::pow(std::cos(angle), 2);
    return {{along, 1.0 + 0.5 * values[0]}, {1.0 - along, 1.0 - 0.5 * values[0]}};
}

} // namespace

EffectPointer out_of_plane() {
    return make_effect(
        {.name = "out_of_plane",
         .family = Family::StemGeometry,
         .summary = "a slightly elliptic section: the swing wanders between two planes and beats",
         .law = "E I (1 ± ε/2) about the two principal axes, the first of which lies at the angle "
                "α from the plane of the pull. Seen from one side: "
                "cos²α cos ω1 t + sin²α cos ω2 t, ω1,2 = ω √(1 ± ε/2)",
         .source = "bending about the principal axes of the section: Timoshenko, Young & Weaver "
                   "(1974), Vibration Problems in Engineering",
         .signature = "the envelope is modulated, with the period 2/(ε f) for a small split ε; "
                      "early in the record it looks like air drag, late like dry friction",
         .remedy = "film with a second camera at a right angle, or turn the stem by 45 degrees "
                   "about its axis; pull along a principal axis and the beating is gone",
         .energy = "stores ½ E I (1 ± ε/2) κ² in the two planes and carries energy from one to the "
                   "other. Conservative, up to the stem's own twist, which is neglected",
         .parameters = {{.name = "stiffness_split",
                         .unit = "",
                         .meaning = "ε: difference of the two stiffnesses over their mean",
                         .default_value = 0.02,
                         .lower = 0.0,
                         .upper = 1.0,
                         .scale = 0.02,
                         // A beat is not a small change of a motion without one.
                         .start_values =
                             [](const StartScales& /*of*/) {
                                 return std::vector{0.02, 0.12};
                             },
                         .start_from_beat = [](const ObservedBeat& beat) { return beat.split; }},
                        {.name = "angle_deg",
                         .unit = "degrees",
                         .meaning = "α: from the plane of the pull to the stiffer principal plane",
                         .default_value = 45.0,
                         .lower = 0.0,
                         .upper = 90.0,
                         .scale = 20.0,
                         .is_place = true,
                         .start_values =
                             [](const StartScales& /*of*/) {
                                 return std::vector{25.0, 60.0};
                             },
                         .start_from_beat =
                             [](const ObservedBeat& beat) {
                                 return beat.angle * 180.0 / std::numbers::pi;
                             }}},
         .dimensions = 3,
         .planar_parts = planar_parts},
        [](std::span<const double> values, EffectTarget& target) {
            if (!target.model.bending)
                target.model.bending.emplace();
            target.model.bending->split = values[0];
            target.model.bending->angle = values[1] * std::numbers::pi / 180.0;
        },
        // Excludes motion in one plane from a fit: steps that are chosen for it are too long for
        // the stem's twist, so the response to a small departure from the plane would be
        // undetermined.
        [](const StemParameters<double>& /*stem*/, std::span<EffectParameter> parameters) {
            parameters[0].lower = 1e-3;
            parameters[1].lower = 3.0;
            parameters[1].upper = 87.0;
        });
}

} // namespace culm::physics
