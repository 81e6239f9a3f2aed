// SPDX-License-Identifier: BSD-3-Clause
// How an implicit integrator weighs the errors of a step, relative to scales of the motion, and the
// longest step that it may take.
#pragma once

#include "core/lanes.hpp"
#include "physics/chain.hpp"
#include "physics/stem.hpp"

#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

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

/// Index of the clamped sphere's spin in the plane of bending.
template <int Dim>
[[nodiscard]] std::size_t base_spin_place(const physics::ChainLayout<Dim>& layout) {
    return layout.sphere_offset(0) + 2 * Dim + physics::bending_axis<Dim>;
}

/// Weights of the errors of the other states, each relative to its scale; the weight of the
/// positions is 1.
struct ErrorShares {
    double rates = 0.0;     ///< velocities and spins
    double histories = 0.0; ///< shear forces and moments of the bonds, moments of their branches
    double geometry = 0.0;  ///< lengths and directions of the bonds
};

/// Weights w in the state's layout: a step with errors e is accepted if Σ (w e)² ≤ 1. Positions
/// may have an error of `tolerance` × displacement scale (root mean square over the chain).
///
/// A clamp that turns has weights for its rotation, with the scale of the stem's rotation, for the
/// moment of a joint that slips, and for its spin: dry friction switches within a small part of the
/// spin's scale, and the positions react too late to errors there.
template <int Dim, class T>
[[nodiscard]] std::vector<T> error_weights(const physics::ChainLayout<Dim>& layout,
                                           const ErrorScalesOf<T>& scales, double tolerance,
                                           const ErrorShares& shares) {
    const T share = T(1.0 / (tolerance * std::sqrt(double(Dim * layout.sphere_count()))));
    const T rate_share = T(shares.rates) * share;
    physics::SphereState<Dim, T> sphere;
    sphere.position.component.fill(share / scales.displacement);
    sphere.velocity.component.fill(rate_share / scales.velocity);
    sphere.spin.component.fill(rate_share / scales.spin);
    physics::BondState<Dim, T> bond;
    const T history_share = T(shares.histories) * share;
    bond.shear_force.component.fill(history_share / scales.shear_force);
    bond.moment.component.fill(history_share / scales.moment);
    const T geometry_share = T(shares.geometry) * share / scales.displacement;
    physics::BondGeometry<Dim, T> geometry;
    geometry.length = geometry_share;
    // The slope of the released stem is spin over velocity times deflection.
    geometry.direction.component.fill(geometry_share * scales.velocity / scales.spin);
    std::vector<T> weights(layout.size(), T(0.0));
    for (int i = 0; i < layout.sphere_count(); ++i)
        layout.set_sphere(weights.data(), i, sphere);
    for (int j = 0; j < layout.bond_count(); ++j) {
        layout.set_bond(weights.data(), j, bond);
        layout.set_geometry(weights.data(), j, geometry);
        for (int branch = 0; branch < layout.branch_count(); ++branch)
            layout.set_branch_moment(weights.data(), j, branch, bond.moment);
    }
    if (layout.base_turns()) {
        constexpr double spin_weight = 0.1;
        const T allowed_rotation =
            T(tolerance) * scales.spin * scales.displacement / scales.velocity;
        weights[layout.base_rotation_offset()] = T(1.0) / allowed_rotation;
        weights[base_spin_place(layout)] = T(spin_weight / tolerance) / scales.spin;
        if (layout.base_slips())
            weights[layout.base_moment_offset()] = T(1.0 / tolerance) / scales.moment;
    }
    return weights;
}

/// The first step to try, s: a thousandth of the period that the scales belong to.
template <class T>
[[nodiscard]] double first_step(const ErrorScalesOf<T>& scales, std::size_t lane = 0) {
    const double period = 6.283185307179586 * core::lane(scales.displacement, lane) /
                          core::lane(scales.velocity, lane);
    return 1e-3 * period;
}

/// A fraction of the support's period, s, or infinity. The error estimate does not detect the
/// motion of a support if the stem is at rest, or if its amplitude is so small that it only serves
/// to compute a derivative.
template <class T>
[[nodiscard]] double longest_step(const physics::ChainModel<T>& model, std::size_t lane = 0) {
    constexpr double steps_per_period = 8.0;
    if (!model.base_motion)
        return std::numeric_limits<double>::infinity();
    return 6.283185307179586 /
           (steps_per_period * core::lane(model.base_motion->angular_frequency, lane));
}

} // namespace culm::integrate
