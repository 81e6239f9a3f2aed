// SPDX-License-Identifier: BSD-3-Clause
// Scales of motion, relative to which an integrator measures its errors.
#pragma once

#include "physics/stem.hpp"

#include <cmath>

namespace culm::integrate {

/// Sizes of displacement, velocity, spin, shear force and moment. T is double, or SIMD lanes.
template <class T>
struct ErrorScalesOf {
    T displacement; ///< m
    T velocity;     ///< m/s
    T spin;         ///< rad/s
    T shear_force;  ///< N
    T moment;       ///< N m
};
using ErrorScales = ErrorScalesOf<double>;

/// Scales of a clamped stem that is released from a tip deflection: the deflection itself, and with
/// Euler-Bernoulli's first mode its velocity, spin, tip force and root moment.
template <class T>
[[nodiscard]] ErrorScalesOf<T> cantilever_scales(const physics::StemParameters<T>& stem,
                                                 const T& tip_deflection) {
    using std::abs;
    using std::sqrt;
    // Euler-Bernoulli cantilever: ω1 = 1.8751² √(EI/(m' L⁴)), tip force 3EIδ/L³.
    const T first_wave_number_squared = T(3.5160);
    const T length = stem.free_length();
    const T bending = stem.bond_youngs_modulus * stem.second_moment_of_area();
    const T mass_per_length = stem.sphere_mass() / stem.bond_length;
    const T omega = first_wave_number_squared *
                    sqrt(bending / (mass_per_length * length * length * length * length));
    const T deflection = abs(tip_deflection);
    const T force = T(3.0) * bending * deflection / (length * length * length);
    return {deflection, omega * deflection, omega * deflection / length, force, force * length};
}

} // namespace culm::integrate
