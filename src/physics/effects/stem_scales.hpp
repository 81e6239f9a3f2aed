// SPDX-License-Identifier: BSD-3-Clause
// Scales of a stem: those of a uniform cantilever beam.
#pragma once

#include "core/cantilever.hpp"
#include "physics/stem.hpp"

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

} // namespace culm::physics
