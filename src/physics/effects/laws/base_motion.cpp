// SPDX-License-Identifier: BSD-3-Clause
// The support vibrates.
#include "physics/effects/effect.hpp"

#include <numbers>

namespace culm::physics {

namespace {

EffectParameter frequency() {
    EffectParameter parameter = place_parameter(
        "frequency_hz", "Hz", "f: frequency of the support",
        {.default_value = 50.0, .lower = 0.01, .upper = 1e5, .scale = 10.0},
        [](const StartScales& of) { return of.residual_peaks(); }, FittedAs::Logarithm);
    parameter.is_excitation = true;
    return parameter;
}

} // namespace

EffectPointer base_motion() {
    return make_effect(
        {.name = "base_motion",
         .family = Family::SupportAndCamera,
         .summary = "the support vibrates sideways",
         .law =
             "x_b(t) = a sin(2π f t + φ); in its frame every mass m feels the force -m d²x_b/dt². "
             "Before the release the support carries the stem and what holds it",
         .source = "Clough & Penzien (1993), Dynamics of Structures, McGraw-Hill (support "
                   "excitation)",
         .signature = "a motion with a separate frequency that does not decay, present at the "
                      "lowest height too and before the release; within 5 % of a natural frequency "
                      "it cannot be told from a shift of that frequency, so it is excluded there",
         .remedy = "keep a fixed mark in view; bolt support and camera to the same table; record "
                   "the stem at rest",
         .energy =
             "puts in or takes out -d²x_b/dt² Σ m v per second, with the speeds v relative to the "
             "support; on average it feeds the stem as much as its damping takes. Not conservative",
         .parameters = {size_parameter(
                            "amplitude_m", "m", "a: amplitude of the support",
                            {.default_value = 1e-4, .lower = 0.0, .upper = 0.1, .scale = 1e-4}),
                        frequency(),
                        {.name = "phase_rad",
                         .unit = "rad",
                         .meaning = "φ: phase at the release",
                         .default_value = 0.0,
                         .lower = -2.0 * std::numbers::pi,
                         .upper = 2.0 * std::numbers::pi,
                         .scale = 1.0,
                         .is_place = true,
                         .is_phase = true,
                         // Two of three directions with positive lengths give every vector.
                         .start_values =
                             [](const StartScales& /*of*/) {
                                 return std::vector{0.0, 2.0 * std::numbers::pi / 3.0,
                                                    -2.0 * std::numbers::pi / 3.0};
                             }}},
         .belongs_to = BelongsTo::Recording},
        [](std::span<const double> values, EffectTarget& target) {
            target.model.base_motion =
                BaseMotion<double>{values[0], 2.0 * std::numbers::pi * values[1], values[2]};
        });
}

} // namespace culm::physics
