// SPDX-License-Identifier: BSD-3-Clause
// Exact derivatives of one bond's response: the force law evaluated with dual numbers.
#pragma once

#include "integrate/lanes_eigen.hpp"
#include "physics/chain.hpp"

#include <optional>

#include <Eigen/Core>
#include <ceres/jet.h>

namespace culm::integrate {

/// Positions of a bond's inputs (columns) and outputs (rows) in its Jacobian.
template <int Dim>
struct BondJacobianLayout {
    static constexpr int rotation = physics::rotation_dimension<Dim>;
    // Inputs (columns).
    static constexpr int velocity = 0;
    static constexpr int spin_1 = Dim;
    static constexpr int spin_2 = Dim + rotation;
    /// The local state of the bond: shear force, moment, length, direction.
    static constexpr int local = Dim + 2 * rotation;
    static constexpr int local_size = 2 * rotation + 1 + Dim;
    static constexpr int length = local + 2 * rotation;
    static constexpr int direction = length + 1;
    static constexpr int inputs = local + local_size;
    // Outputs (rows).
    static constexpr int force = 0;
    static constexpr int torque_1 = Dim;
    static constexpr int torque_2 = Dim + rotation;
    static constexpr int local_rate = Dim + 2 * rotation; ///< includes the rotation with the bond
    static constexpr int outputs = local_rate + local_size;
};

/// Everything that the response of a bond depends on.
template <int Dim, class T>
struct BondInputs {
    physics::BondMotion<Dim, T> motion;
    physics::BondState<Dim, T> state;
    physics::BondGeometry<Dim, T> geometry;
    physics::BondExtras<Dim, T> extras = {};
};

/// d(force, torques, rates of the local state)/d(relative velocity, spins, local state).
template <int Dim, class T = double>
using BondJacobian =
    Eigen::Matrix<T, BondJacobianLayout<Dim>::outputs, BondJacobianLayout<Dim>::inputs>;

/// Coefficients of a bond as dual numbers that depend on nothing.
template <class Dual, class T>
[[nodiscard]] physics::BondCoefficients<Dual> as_dual(const physics::BondCoefficients<T>& bond) {
    return {Dual(bond.length),
            Dual(bond.span),
            Dual(bond.share_1),
            Dual(bond.share_2),
            Dual(bond.normal_stiffness),
            Dual(bond.shear_stiffness),
            Dual(bond.torsion_stiffness),
            Dual(bond.bending_stiffness),
            Dual(bond.normal_damping),
            Dual(bond.shear_damping),
            Dual(bond.torsion_damping),
            Dual(bond.bending_damping)};
}

/// A law of three numbers (of bending or its loss) as dual numbers that depend on nothing.
template <class Dual, template <class> class Law, class T>
[[nodiscard]] std::optional<Law<Dual>> as_dual(const std::optional<Law<T>>& law) {
    if (!law)
        return std::nullopt;
    const auto& [first, second, third] = *law;
    return Law<Dual>{Dual(first), Dual(second), Dual(third)};
}

/// Evaluates Jacobians of bonds; T is double or SIMD lanes.
template <int Dim, class T = double>
class BondDifferentiator {
    using Layout = BondJacobianLayout<Dim>;
    /// Directions of a dual number: so small that its arithmetic uses registers only (measured).
    static constexpr int directions = Dim == 2 ? 3 : 2;
    using Dual = ceres::Jet<T, directions>;

  public:
    explicit BondDifferentiator(const physics::Chain<Dim, T>& chain)
        : chain_(chain), bond_(as_dual<Dual>(chain.bond_coefficients())),
          bending_(as_dual<Dual>(chain.model().bending)),
          loss_(as_dual<Dual>(chain.model().bending_loss)) {}

    /// The Jacobian of bond `j` at `state` (the chain's layout) and `time`. The moments of Maxwell
    /// branches are treated as constants: CondensedNewton eliminates them.
    void evaluate(const T* state, int j, const T& time, BondJacobian<Dim, T>& out) {
        const auto& layout = chain_.layout();
        BondInputs<Dim, T> bond{
            chain_.motion_between(layout.sphere(state, j), layout.sphere(state, j + 1)),
            layout.bond(state, j), layout.geometry(state, j)};
        if (chain_.is_plain()) {
            for (int first = 0; first < Layout::inputs; first += directions)
                evaluate_columns<true>(bond, first, out);
            return;
        }
        bond.extras = chain_.bond_extras(state, j, time, true);
        if (chain_.model().bonds.size() > 1)
            bond_ = as_dual<Dual>(chain_.bond_coefficients(j));
        for (int first = 0; first < Layout::inputs; first += directions)
            evaluate_columns<false>(bond, first, out);
    }

  private:
    /// The columns first, … first + directions − 1.
    template <bool IsPlain>
    [[gnu::flatten]] void evaluate_columns(const BondInputs<Dim, T>& bond, int first,
                                           BondJacobian<Dim, T>& out) const {
        physics::BondMotion<Dim, Dual> motion;
        motion.velocity = seeded(bond.motion.velocity, Layout::velocity - first);
        motion.spin_1 = seeded(bond.motion.spin_1, Layout::spin_1 - first);
        motion.spin_2 = seeded(bond.motion.spin_2, Layout::spin_2 - first);
        const physics::BondState<Dim, Dual> state{
            seeded(bond.state.shear_force, Layout::local - first),
            seeded(bond.state.moment, Layout::local + Layout::rotation - first)};
        const core::Vec<1, Dual> length =
            seeded(core::Vec<1, T>{{bond.geometry.length}}, Layout::length - first);
        const physics::BondFrame<Dim, Dual> frame(
            length[0], seeded(bond.geometry.direction, Layout::direction - first));
        physics::BondState<Dim, Dual> loaded = state;
        if constexpr (!IsPlain)
            loaded.moment = physics::loaded_moment(bending_, loss_, bond_, frame, motion,
                                                   state.moment, bond.extras);
        physics::BondResponse<Dim, Dual> response =
            physics::bond_response(bond_, chain_.law(), frame, motion, loaded);
        response.rate.shear_force += frame.shear_turning_rate(state.shear_force, motion.velocity);
        response.rate.moment += frame.moment_turning_rate(state.moment, motion.velocity);
        const physics::BondGeometry<Dim, Dual> geometry =
            physics::Chain<Dim, Dual>::geometry_rate(frame, motion.velocity);

        store(response.force, Layout::force, first, out);
        store(response.torque_1, Layout::torque_1, first, out);
        store(response.torque_2, Layout::torque_2, first, out);
        store(response.rate.shear_force, Layout::local_rate, first, out);
        store(response.rate.moment, Layout::local_rate + Layout::rotation, first, out);
        store(core::Vec<1, Dual>{{geometry.length}}, Layout::local_rate + 2 * Layout::rotation,
              first, out);
        store(geometry.direction, Layout::local_rate + 2 * Layout::rotation + 1, first, out);
    }

    /// `v` as dual numbers; component i has the direction first + i, if that direction exists.
    template <int N>
    [[nodiscard]] static core::Vec<N, Dual> seeded(const core::Vec<N, T>& v, int first) {
        core::Vec<N, Dual> out;
        for (int i = 0; i < N; ++i) {
            out[i].a = v[i];
            for (int k = 0; k < directions; ++k)
                out[i].v(k) = T(first + i == k ? 1.0 : 0.0);
        }
        return out;
    }
    template <int N>
    static void store(const core::Vec<N, Dual>& v, int first_row, int first_column,
                      BondJacobian<Dim, T>& out) {
        for (int i = 0; i < N; ++i)
            for (int k = 0; k < directions && first_column + k < Layout::inputs; ++k)
                out(first_row + i, first_column + k) = v[i].v(k);
    }

    const physics::Chain<Dim, T>& chain_;
    physics::BondCoefficients<Dual> bond_;
    std::optional<physics::BendingLaw<Dual>> bending_;
    std::optional<physics::BendingLoss<Dual>> loss_;
};

} // namespace culm::integrate
