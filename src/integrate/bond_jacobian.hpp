// SPDX-License-Identifier: BSD-3-Clause
// Exact derivatives of one bond's response, by dual numbers through the one force law.
#pragma once

#include "physics/chain.hpp"

#include <Eigen/Core>
#include <ceres/jet.h>

namespace culm::integrate {

/// Where inputs and outputs of a bond stand in its Jacobian.
template <int Dim>
struct BondJacobianLayout {
    static constexpr int rotation = physics::rotation_dimension<Dim>;
    // Inputs (columns).
    static constexpr int separation = 0;
    static constexpr int velocity = Dim;
    static constexpr int spin_1 = 2 * Dim;
    static constexpr int spin_2 = 2 * Dim + rotation;
    static constexpr int history = 2 * Dim + 2 * rotation; ///< shear force, then moment
    static constexpr int history_size = 2 * rotation;
    static constexpr int inputs = history + history_size;
    // Outputs (rows).
    static constexpr int force = 0;
    static constexpr int torque_1 = Dim;
    static constexpr int torque_2 = Dim + rotation;
    static constexpr int history_rate = Dim + 2 * rotation; ///< turning with the bond included
    static constexpr int outputs = history_rate + history_size;
};

/// d(force, torques, history rates)/d(separation, relative velocity, spins, history).
template <int Dim>
using BondJacobian =
    Eigen::Matrix<double, BondJacobianLayout<Dim>::outputs, BondJacobianLayout<Dim>::inputs>;

/// Coefficients of a bond as dual numbers that depend on nothing.
template <class Dual>
[[nodiscard]] physics::BondCoefficients<Dual>
as_dual(const physics::BondCoefficients<double>& bond) {
    return {Dual(bond.length),
            Dual(bond.radius_1),
            Dual(bond.radius_2),
            Dual(bond.normal_stiffness),
            Dual(bond.shear_stiffness),
            Dual(bond.torsion_stiffness),
            Dual(bond.bending_stiffness),
            Dual(bond.normal_damping),
            Dual(bond.shear_damping),
            Dual(bond.torsion_damping),
            Dual(bond.bending_damping)};
}

/// Evaluates Jacobians of bonds that share their coefficients.
template <int Dim>
class BondDifferentiator {
    using Layout = BondJacobianLayout<Dim>;
    using Dual = ceres::Jet<double, Layout::inputs>;

  public:
    BondDifferentiator(const physics::BondCoefficients<double>& bond,
                       const physics::BondLawOptions& law)
        : bond_(as_dual<Dual>(bond)), law_(law) {}

    void evaluate(const physics::BondMotion<Dim, double>& motion,
                  const physics::BondState<Dim, double>& state, BondJacobian<Dim>& out) const {
        const physics::BondMotion<Dim, Dual> dual_motion{
            seeded(motion.separation, Layout::separation),
            seeded(motion.velocity, Layout::velocity), seeded(motion.spin_1, Layout::spin_1),
            seeded(motion.spin_2, Layout::spin_2)};
        const physics::BondState<Dim, Dual> dual_state{
            seeded(state.shear_force, Layout::history),
            seeded(state.moment, Layout::history + Layout::rotation)};
        const physics::BondFrame<Dim, Dual> frame(dual_motion.separation);
        physics::BondResponse<Dim, Dual> response =
            physics::bond_response(bond_, law_, frame, dual_motion, dual_state);
        response.rate.shear_force +=
            frame.shear_turning_rate(dual_state.shear_force, dual_motion.velocity);
        response.rate.moment += frame.moment_turning_rate(dual_state.moment, dual_motion.velocity);

        store(response.force, Layout::force, out);
        store(response.torque_1, Layout::torque_1, out);
        store(response.torque_2, Layout::torque_2, out);
        store(response.rate.shear_force, Layout::history_rate, out);
        store(response.rate.moment, Layout::history_rate + Layout::rotation, out);
    }

  private:
    template <int N>
    [[nodiscard]] static core::Vec<N, Dual> seeded(const core::Vec<N, double>& v, int first) {
        core::Vec<N, Dual> out;
        for (int i = 0; i < N; ++i)
            out[i] = Dual(v[i], first + i);
        return out;
    }
    template <int N>
    static void store(const core::Vec<N, Dual>& v, int first_row, BondJacobian<Dim>& out) {
        for (int i = 0; i < N; ++i)
            out.row(first_row + i) = v[i].v.transpose();
    }

    physics::BondCoefficients<Dual> bond_;
    physics::BondLawOptions law_;
};

} // namespace culm::integrate
