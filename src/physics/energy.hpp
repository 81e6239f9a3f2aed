// SPDX-License-Identifier: BSD-3-Clause
// Energy, dissipated power and momenta of a chain: the balances of its motion.
#pragma once

#include "physics/chain.hpp"

namespace culm::physics {

/// Elastic energy of one bond, J: ½k_n(r−l)² + F²/2k_t + M_n²/2k_tor + M_t²/2k_b.
template <int Dim, class T>
[[nodiscard]] T elastic_energy(const BondCoefficients<T>& bond, const BondFrame<Dim, T>& frame,
                               const BondState<Dim, T>& state) {
    const T elongation = frame.length() - bond.length;
    const Rotational<Dim, T> twisting = frame.twist(state.moment);
    const Rotational<Dim, T> bending = state.moment - twisting;
    return T(0.5) * (bond.normal_stiffness * elongation * elongation +
                     dot(state.shear_force, state.shear_force) / bond.shear_stiffness +
                     dot(twisting, twisting) / bond.torsion_stiffness +
                     dot(bending, bending) / bond.bending_stiffness);
}

/// Power that the damping forces of one bond dissipate, W. If the shear damping exerts no torque,
/// it does work on the translation alone.
template <int Dim, class T>
[[nodiscard]] T dissipated_power(const BondCoefficients<T>& bond, const BondLawOptions& law,
                                 const BondFrame<Dim, T>& frame, const BondMotion<Dim, T>& motion) {
    const Rotational<Dim, T> sliding =
        shear_velocity(frame, motion, lever_arms(bond, law, frame.length()));
    const Rotational<Dim, T> worked =
        law.shear_damping_torque ? sliding : frame.transverse(motion.velocity);
    const Rotational<Dim, T> relative_spin = motion.spin_2 - motion.spin_1;
    const Rotational<Dim, T> twisting = frame.twist(relative_spin);
    const Rotational<Dim, T> bending = relative_spin - twisting;
    const T stretching = dot(motion.velocity, frame.direction());
    return bond.normal_damping * stretching * stretching +
           bond.shear_damping * dot(sliding, worked) +
           bond.torsion_damping * dot(twisting, twisting) +
           bond.bending_damping * dot(bending, bending);
}

/// The energy account of a chain at one instant.
template <class T>
struct ChainEnergy {
    T kinetic;          ///< J
    T elastic;          ///< J
    T gravitational;    ///< J, relative to the height of the clamp
    T dissipated_power; ///< W

    [[nodiscard]] T stored() const { return kinetic + elastic + gravitational; }
};

/// Energy of nonlinear or split bending in addition to the linear elastic one, ∫ (M − m) dm/k_b,
/// and the stored energy and dissipation of Maxwell branches: q²/2gk_b, q²/(gk_b τ).
template <int Dim, class T>
void add_bond_effects(const Chain<Dim, T>& chain, const T* state, int j,
                      const BondFrame<Dim, T>& frame, ChainEnergy<T>& energy) {
    const auto& layout = chain.layout();
    const BondCoefficients<T>& bond = chain.bond_coefficients(j);
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
        energy.elastic =
            energy.elastic + (T(0.5) * by_split + T(0.25) * by_cubic) / bond.bending_stiffness;
    }
    for (int k = 0; k < layout.branch_count(); ++k) {
        const MaxwellBranch<T>& branch = chain.model().branches[static_cast<std::size_t>(k)];
        const Rotational<Dim, T> moment = layout.branch_moment(state, j, k);
        // A branch without stiffness carries no moment.
        const T stored = T(0.5) * dot(moment, moment) /
                         (branch.relative_stiffness * bond.bending_stiffness + T(1e-300));
        energy.elastic = energy.elastic + stored;
        energy.dissipated_power =
            energy.dissipated_power + T(2.0) * stored / branch.relaxation_time;
    }
}

/// Adds resistance, which dissipates −force·velocity for every law, and the clamp's spring and
/// friction. The work of users' laws and of time-dependent forces is not included.
template <int Dim, class T>
void add_outer_effects(const Chain<Dim, T>& chain, const T* state, ChainEnergy<T>& energy) {
    const auto& layout = chain.layout();
    const ChainModel<T>& model = chain.model();
    for (int i = 0; !model.air.empty() && i < layout.sphere_count(); ++i) {
        const Vec<Dim, T> velocity = layout.sphere(state, i).velocity;
        NodeLoad<Dim, T> load;
        add_air_drag(std::span<const AirDrag<T>>(model.air), chain.length_at(i), velocity, load);
        energy.dissipated_power = energy.dissipated_power - dot(load.force, velocity);
    }
    if (model.hinge) {
        const T rotation = state[layout.base_rotation_offset()];
        const T rate = layout.sphere(state, 0).spin[bending_axis<Dim>];
        energy.elastic = energy.elastic + T(0.5) * model.hinge->stiffness * rotation * rotation;
        energy.dissipated_power =
            energy.dissipated_power - hinge_moment(*model.hinge, T(0.0), rate).moment * rate;
    }
}

template <int Dim, class T>
[[nodiscard]] ChainEnergy<T> chain_energy(const Chain<Dim, T>& chain, const T* state) {
    const auto& layout = chain.layout();
    ChainEnergy<T> energy{T(0.0), T(0.0), T(0.0), T(0.0)};
    for (int i = 0; i < layout.sphere_count(); ++i) {
        const SphereInertia<T>& inertia = chain.sphere_inertia(i);
        const SphereState<Dim, T> sphere = layout.sphere(state, i);
        energy.kinetic =
            energy.kinetic + T(0.5) * (inertia.mass * dot(sphere.velocity, sphere.velocity) +
                                       inertia.moment * dot(sphere.spin, sphere.spin));
        energy.gravitational =
            energy.gravitational - inertia.mass * dot(chain.gravity(), sphere.position);
    }
    for (int j = 0; j < layout.bond_count(); ++j) {
        const BondMotion<Dim, T> motion =
            chain.motion_between(layout.sphere(state, j), layout.sphere(state, j + 1));
        const BondFrame<Dim, T> frame(motion.separation);
        const BondCoefficients<T>& bond = chain.bond_coefficients(j);
        energy.elastic = energy.elastic + elastic_energy(bond, frame, layout.bond(state, j));
        if (!chain.is_plain())
            add_bond_effects(chain, state, j, frame, energy);
        energy.dissipated_power =
            energy.dissipated_power + dissipated_power(bond, chain.law(), frame, motion);
    }
    if (!chain.is_plain())
        add_outer_effects(chain, state, energy);
    return energy;
}

} // namespace culm::physics
