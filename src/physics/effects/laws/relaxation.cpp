// SPDX-License-Identifier: BSD-3-Clause
// The stem's material relaxes: it creeps while it is held, and drifts back after the release.
#include "physics/effects/effect.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace culm::physics {

namespace {

std::vector<double> relaxation_start_times(const StartScales& of) {
    // From ωτ = 1, where a branch damps the motion most, to a τ that still differs from a drift.
    const double shortest = 1.0 / (2.0 * std::numbers::pi * of.first_frequency);
    const double longest = std::max(of.duration / 3.0, shortest);
    // For τ beyond the record the mean only tilts; only such a τ resembles a curvature.
    return {shortest, std::sqrt(shortest * longest), longest, 6.0 * longest};
}

} // namespace

EffectPointer relaxation() {
    return make_effect(
        {.name = "relaxation",
         .family = Family::MaterialDamping,
         .summary = "the material relaxes: creep while held, slow drift after the release",
         .law =
             "M = E I κ + q, dq/dt = g E I dκ/dt - q/τ (standard linear solid). Y is the relaxed "
             "modulus; fast motion sees Y (1 + g). Held for t_h, q = g E I κ exp(-t_h/τ) is left",
         .source = "Zener (1948), Elasticity and Anelasticity of Metals, Univ. of Chicago Press",
         .signature =
             "long τ: after the release the mean position creeps back from the side of the "
             "hold, as exp(-t/τ), with the static shape; short τ: only more decay and a "
             "higher frequency, no distinct signature",
         .remedy = "vary the time for which the stem is held, and release it from the other side; "
                   "long τ needs a long record. hold_time_s is known: state it in the measurement",
         .energy = "stores q²/(2 g E I) per length besides bending and takes out q²/(g E I τ) per "
                   "second. The energy that it stores after the hold is part of the energy at the "
                   "release; it supplies no other energy",
         .parameters =
             {size_parameter("fraction", "", "g: modulus that relaxes over the relaxed one",
                             {.default_value = 0.03, .lower = 0.0, .upper = 2.0, .scale = 0.02}),
              place_parameter("time_s", "s", "τ: relaxation time",
                              {.default_value = 0.1, .lower = 1e-5, .upper = 1e4, .scale = 0.1},
                              relaxation_start_times, FittedAs::Logarithm),
              hold_time_parameter()},
         .revealed_by = {{"hold the stem ten times as long before the release", {1.0, 1.0, 10.0}}}},
        [](std::span<const double> values, EffectTarget& target) {
            // While the stem is held, dκ/dt = 0 and q decays from g E I κ; the share exp(−t_h/τ)
            // remains at the release.
            const double fraction = values[0];
            const double time = values[1];
            const double hold_time = values[2];
            target.model.branches.push_back({.relative_stiffness = fraction,
                                             .relaxation_time = time,
                                             .held_share = std::exp(-hold_time / time)});
        });
}

} // namespace culm::physics
