// SPDX-License-Identifier: BSD-3-Clause
// Scales of a stem: those of a uniform cantilever beam.
#pragma once

#include "core/cantilever.hpp"
#include "physics/effects/effect.hpp"
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

/// First natural frequency of the Euler-Bernoulli cantilever, Hz.
[[nodiscard]] inline double first_frequency(const StemParameters<double>& stem) {
    return core::cantilever_frequency(stem.free_length(), bending_rigidity(stem),
                                      mass_per_length(stem));
}

/// Strain to which losses and slip refer.
inline constexpr double reference_strain = 1e-3;

/// Strain of the outermost fibre at the clamp when the tip is pulled aside by a tenth of the
/// length.
[[nodiscard]] inline double pulled_strain(const StemParameters<double>& stem) {
    return 0.3 * stem.outer_fibre() / stem.free_length();
}

/// Angular frequency of mode 1 with the attached masses, rad/s, by Rayleigh's quotient: the kinetic
/// energy of mode 1 is that of a quarter of the stem's mass at the tip, and x²(3 − x)/2 is close to
/// its shape.
[[nodiscard]] inline double loaded_angular_frequency(const EffectTarget& target) {
    const StemParameters<double>& stem = target.stem;
    double share = 1.0;
    for (const AttachedMass& mass : target.attached) {
        const double x = std::min(mass.position / stem.free_length(), 1.0);
        const double shape = 0.5 * x * x * (3.0 - x);
        share += mass.mass * shape * shape / (0.25 * mass_per_length(stem) * stem.free_length());
    }
    return 2.0 * std::numbers::pi * first_frequency(stem) / std::sqrt(share);
}

} // namespace culm::physics
