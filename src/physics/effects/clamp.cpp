// SPDX-License-Identifier: BSD-3-Clause
#include "physics/effects/clamp.hpp"

#include "physics/effects/stem_scales.hpp"

#include <algorithm>

namespace culm::physics {

EffectParameter clamp_stiffness() {
    return {.name = "stiffness_nm_rad",
            .unit = "N m/rad",
            .meaning = "k: rotational stiffness of the clamp",
            .default_value = 1.0,
            .lower = 1e-8,
            .upper = 1e8,
            .scale = 1.0,
            .fitted_as = FittedAs::Inverse};
}

EffectParameter clamp_friction_rate() {
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

void suit_clamp_stiffness(const StemParameters<double>& stem, EffectParameter& stiffness) {
    const double typical = 50.0 * stiffness_scale(stem);
    stiffness.default_value = typical;
    stiffness.scale = typical;
    stiffness.lower = std::max(stiffness.lower, 1e-3 * typical);
    stiffness.upper = std::min(stiffness.upper, 1e4 * typical);
}

} // namespace culm::physics
