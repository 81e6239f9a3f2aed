// SPDX-License-Identifier: BSD-3-Clause
// Scales of a stem: those of a uniform cantilever beam.
#pragma once

#include "physics/stem.hpp"

#include <cmath>
#include <numbers>

namespace culm::physics {

/// E I, N m².
[[nodiscard]] inline double bending_rigidity(const StemParameters<double>& stem) {
    return stem.bond_youngs_modulus * stem.second_moment_of_area();
}

/// kg/m.
[[nodiscard]] inline double mass_per_length(const StemParameters<double>& stem) {
    return stem.sphere_mass() / stem.bond_length;
}

/// E I/L, N m/rad: the scale for the stiffness of a clamp.
[[nodiscard]] inline double stiffness_scale(const StemParameters<double>& stem) {
    return bending_rigidity(stem) / stem.free_length();
}

/// First natural frequency of the Euler-Bernoulli cantilever, 1.8751²/(2πL²) √(E I/m'), Hz.
[[nodiscard]] inline double first_frequency(const StemParameters<double>& stem) {
    constexpr double root = 1.8751040687119611; // of cos x cosh x = −1
    const double length = stem.free_length();
    return root * root / (2.0 * std::numbers::pi * length * length) *
           std::sqrt(bending_rigidity(stem) / mass_per_length(stem));
}

} // namespace culm::physics
