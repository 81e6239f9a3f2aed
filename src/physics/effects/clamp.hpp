// SPDX-License-Identifier: BSD-3-Clause
// Parameters that the effects of a yielding clamp share.
#pragma once

#include "physics/effects/effect.hpp"
#include "physics/effects/stem_scales.hpp"

#include <algorithm>

namespace culm::physics {

/// Stiffness of the clamp's rotational spring.
[[nodiscard]] inline EffectParameter clamp_stiffness() {
    return {.name = "stiffness_nm_rad",
            .unit = "N m/rad",
            .meaning = "k: rotational stiffness of the clamp",
            .default_value = 1.0,
            .lower = 1e-8,
            .upper = 1e8,
            .scale = 1.0,
            .fitted_as = FittedAs::Inverse};
}

/// The same as a location: a rigid clamp has no friction, and the spring only defines where
/// friction acts.
[[nodiscard]] inline EffectParameter clamp_spring() {
    EffectParameter stiffness = clamp_stiffness();
    stiffness.is_place = true;
    stiffness.start_values = [](const StartScales& of) {
        return std::vector{2.0 * of.stiffness, 10.0 * of.stiffness, 50.0 * of.stiffness};
    };
    return stiffness;
}

/// Rate at which dry friction is three quarters of its full moment. Fixed: it only regularises.
[[nodiscard]] inline EffectParameter clamp_friction_rate() {
    return {.name = "rate_rad_s",
            .unit = "rad/s",
            .meaning = "ω_r: rate at which friction is three quarters of M_f; regularises, not "
                       "fitted",
            .default_value = 0.05,
            .lower = 1e-4,
            .upper = 10.0,
            .scale = 0.05,
            .calibrated = false};
}

/// Loss factor of the clamp's spring: 0 for a perfect one, and some hundredths for vises, glue and
/// fingers. The bonds' damping imitates it, so its prior is part of the fit.
[[nodiscard]] inline EffectParameter clamp_loss() {
    EffectParameter loss = place_parameter(
        "loss_factor", "", "η: loss of the spring in a cycle over 2π times its energy",
        {.default_value = 0.0, .lower = 0.0, .upper = 0.1, .scale = 0.02},
        [](const StartScales& /*of*/) { return std::vector{0.0}; });
    loss.known_within = 0.05;
    return loss;
}

/// A clamp that lowers the frequencies by some 4 % is a common one; one a thousand times softer
/// does not hold the stem, and one a thousand times stiffer is indistinguishable from a rigid one.
inline void suit_clamp_stiffness(const StemParameters<double>& stem, EffectParameter& stiffness) {
    const double typical = 50.0 * stiffness_scale(stem);
    stiffness.default_value = typical;
    stiffness.scale = typical;
    stiffness.lower = std::max(stiffness.lower, 1e-3 * typical);
    stiffness.upper = std::min(stiffness.upper, 1e4 * typical);
}

} // namespace culm::physics
