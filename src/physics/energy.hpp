// SPDX-License-Identifier: BSD-3-Clause
// Energy that a chain stores.
#pragma once

#include "physics/chain.hpp"

namespace culm::physics {

/// Elastic energy of one bond, J: ½k_n(r−l)² + F²/2k_t + M_n²/2k_tor + M_t²/2k_b.
template <int Dim, class T>
[[nodiscard]] T elastic_energy(const BondCoefficients<T>& bond, const BondFrame<Dim, T>& frame,
                               const BondState<Dim, T>& state) {
    const T elongation = frame.length() - bond.length;
    const Rotational<Dim, T> turns = frame.scaled(T(1.0) / bond.torsion_stiffness,
                                                  T(1.0) / bond.bending_stiffness, state.moment);
    return T(0.5) * (bond.normal_stiffness * elongation * elongation +
                     dot(state.shear_force, state.shear_force) / bond.shear_stiffness +
                     dot(state.moment, turns));
}

/// Energy of nonlinear or split bending in addition to the linear elastic one, ∫ (M − m) dm/k_b,
/// and the stored energy of Maxwell branches, q²/2gk_b; J.
template <int Dim, class T>
[[nodiscard]] T energy_of_bond_effects(const Chain<Dim, T>& chain, const T* state, int j,
                                       const BondFrame<Dim, T>& frame) {
    const auto& layout = chain.layout();
    const BondCoefficients<T>& bond = chain.bond_coefficients(j);
    T energy = T(0.0);
    if (chain.model().bending) {
        // The split part is linear in the moment, the cubic one of third order.
        BendingLaw<T> split = *chain.model().bending;
        BendingLaw<T> cubic = split;
        split.cubic = T(0.0);
        cubic.split = T(0.0);
        const Rotational<Dim, T> linear = layout.bond(state, j).moment;
        const T per_curvature = bond.bending_stiffness * bond.length;
        const T by_split =
            dot(linear, elastic_moment(split, per_curvature, frame, linear) - linear);
        const T by_cubic =
            dot(linear, elastic_moment(cubic, per_curvature, frame, linear) - linear);
        energy = (T(0.5) * by_split + T(0.25) * by_cubic) / bond.bending_stiffness;
    }
    for (int k = 0; k < layout.branch_count(); ++k) {
        const MaxwellBranch<T>& branch = chain.model().branches[static_cast<std::size_t>(k)];
        const Rotational<Dim, T> moment = layout.branch_moment(state, j, k);
        // A branch without stiffness carries no moment.
        energy = energy + T(0.5) * dot(moment, moment) /
                              (branch.relative_stiffness * bond.bending_stiffness + T(1e-300));
    }
    return energy;
}

/// Kinetic and elastic energy, and that of gravity relative to the height of the clamp, J.
template <int Dim, class T>
[[nodiscard]] T stored_energy(const Chain<Dim, T>& chain, const T* state) {
    const auto& layout = chain.layout();
    T energy = T(0.0);
    for (int i = 0; i < layout.sphere_count(); ++i) {
        const SphereInertia<T>& inertia = chain.sphere_inertia(i);
        const SphereState<Dim, T> sphere = layout.sphere(state, i);
        energy = energy +
                 T(0.5) * (inertia.mass * dot(sphere.velocity, sphere.velocity) +
                           inertia.moment * dot(sphere.spin, sphere.spin)) +
                 chain.air_energy(i, sphere.velocity) -
                 inertia.mass * dot(chain.gravity(), sphere.position);
    }
    for (int j = 0; j < layout.bond_count(); ++j) {
        const BondFrame<Dim, T> frame(layout.sphere(state, j + 1).position -
                                      layout.sphere(state, j).position);
        energy = energy + elastic_energy(chain.bond_coefficients(j), frame, layout.bond(state, j));
        if (!chain.is_plain())
            energy = energy + energy_of_bond_effects(chain, state, j, frame);
    }
    if (const auto& hinge = chain.model().hinge) {
        // A joint that slips stores what unloading with its full stiffness gives back.
        const BaseState<T> base = chain.base_state(state);
        energy = energy + (chain.model().slip
                               ? T(0.5) * base.moment * base.moment / hinge->stiffness
                               : T(0.5) * hinge->stiffness * base.rotation * base.rotation);
    }
    return energy;
}

} // namespace culm::physics
