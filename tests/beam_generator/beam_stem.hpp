// SPDX-License-Identifier: BSD-3-Clause
// The stem of a made-up recording: a solid beam with internal damping, round or a strip.
#pragma once

#include <cmath>
#include <numbers>

namespace culm::beam {

/// SI units. Section and mass as measure::MeasuredStem defines them for a solid circular section.
struct BeamStem {
    double length = 0.16;
    double diameter = 2.83e-3;
    double density = 125.0;
    double youngs_modulus = 2.2e9;
    double damping_time = 1.5e-4; ///< τ of M = E I (κ + τ κ̇), s
    /// Of a strip, m, whose depth in the direction of the motion is the diameter; 0: round.
    double width = 0.0;

    /// E I, N m².
    [[nodiscard]] double rigidity() const {
        return youngs_modulus * (width > 0.0 ? width * std::pow(diameter, 3) / 12.0
                                             : std::numbers::pi / 64.0 * std::pow(diameter, 4));
    }
    /// One sphere of the diameter d per length d, kg/m; of a strip that of the section.
    [[nodiscard]] double mass_per_length() const {
        return width > 0.0 ? density * width * diameter
                           : density * std::numbers::pi / 6.0 * diameter * diameter;
    }
    /// First frequency of the slender, undamped cantilever, Hz.
    [[nodiscard]] double first_frequency() const {
        constexpr double root_squared = 3.51601526850015; // 1.8751…², of cos x cosh x = −1
        return root_squared / (2.0 * std::numbers::pi * length * length) *
               std::sqrt(rigidity() / mass_per_length());
    }
};

} // namespace culm::beam
