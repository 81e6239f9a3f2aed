// SPDX-License-Identifier: BSD-3-Clause
// Power that a chain dissipates: the other side of the balance of its stored energy.
#pragma once

#include "physics/chain.hpp"

namespace culm::tests {

/// Power that the damping forces of one bond dissipate, W. If the shear damping exerts no torque,
/// it does work on the translation alone.
template <int Dim, class T>
[[nodiscard]] T bond_dissipation(const physics::BondCoefficients<T>& bond,
                                 const physics::BondLawOptions& law,
                                 const physics::BondFrame<Dim, T>& frame,
                                 const physics::BondMotion<Dim, T>& motion) {
    const physics::Rotational<Dim, T> sliding =
        physics::shear_velocity(frame, motion, physics::lever_arms(bond, law, frame.length()));
    const physics::Rotational<Dim, T> worked =
        law.shear_damping_torque ? sliding : frame.transverse(motion.velocity);
    const physics::Rotational<Dim, T> relative_spin = motion.spin_2 - motion.spin_1;
    const T stretching = dot(motion.velocity, frame.direction());
    return bond.normal_damping * stretching * stretching +
           bond.shear_damping * dot(sliding, worked) +
           dot(relative_spin,
               frame.scaled(bond.torsion_damping, bond.bending_damping, relative_spin));
}

/// Power of the loss that grows with the bend, W.
template <int Dim>
[[nodiscard]] double bending_loss_power(const physics::Chain<Dim, double>& chain,
                                        const double* state, int j,
                                        const physics::BondMotion<Dim, double>& motion) {
    const auto& bond = chain.bond_coefficients(j);
    const double curvature =
        physics::bond_curvature<Dim>(bond, chain.layout().bond(state, j).moment);
    const double rate = physics::bond_curvature_rate<Dim>(bond, motion);
    return bond.bending_stiffness * bond.length * bond.length *
           physics::loss_time(*chain.model().bending_loss, curvature) * rate * rate;
}

/// Power that bonds, Maxwell branches, air and the losses of the clamp dissipate, W. The work of
/// users' laws and of forces that depend on time is not included.
template <int Dim>
[[nodiscard]] double dissipated_power(const physics::Chain<Dim, double>& chain,
                                      const double* state) {
    const auto& layout = chain.layout();
    const auto& model = chain.model();
    double power = 0.0;
    for (int j = 0; j < layout.bond_count(); ++j) {
        const auto motion =
            chain.motion_between(layout.sphere(state, j), layout.sphere(state, j + 1));
        const physics::BondFrame<Dim, double> frame(motion.separation);
        const auto& bond = chain.bond_coefficients(j);
        power += bond_dissipation(bond, chain.law(), frame, motion);
        if (model.bending_loss)
            power += bending_loss_power(chain, state, j, motion);
        for (int k = 0; k < layout.branch_count(); ++k) {
            const auto& branch = model.branches[static_cast<std::size_t>(k)];
            const auto moment = layout.branch_moment(state, j, k);
            // A branch without stiffness carries no moment.
            power += dot(moment, moment) / branch.relaxation_time /
                     (branch.relative_stiffness * bond.bending_stiffness + 1e-300);
        }
    }
    // Resistance dissipates −force·velocity for every law.
    for (int i = 0; !model.air.empty() && i < layout.sphere_count(); ++i) {
        const auto velocity = layout.sphere(state, i).velocity;
        physics::NodeLoad<Dim, double> load;
        physics::add_air_drag(std::span<const physics::AirDrag<double>>(model.air),
                              chain.length_at(i), velocity, load);
        power -= dot(load.force, velocity);
    }
    if (model.hinge) {
        const physics::BaseState<double> base = chain.base_state(state);
        power -= physics::hinge_moment(*model.hinge, 0.0, base.rate).moment * base.rate;
        // The part of the turn that the spring does not store.
        if (model.slip)
            power += base.moment *
                     (base.rate -
                      physics::slip_rate(*model.hinge, *model.slip, base.moment, base.rate).value /
                          model.hinge->stiffness);
    }
    return power;
}

} // namespace culm::tests
