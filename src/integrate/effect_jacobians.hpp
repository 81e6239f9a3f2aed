// SPDX-License-Identifier: BSD-3-Clause
// What physical effects add to the Newton system of a chain: forces on single spheres, a clamp that
// turns, and Maxwell branches.
#pragma once

#include "integrate/lanes_eigen.hpp"
#include "physics/chain.hpp"

#include <vector>

#include <Eigen/Core>

namespace culm::integrate {

/// The part of the system (I − γJ) δ = b that the bonds' own Jacobians do not hold. With
/// displacements δx = b_x + γ δv, clamp rotation δθ = b_θ + γ δω_0 and branch moments
///   δq = (b_q + γ g k_b δω_bend)/(1 + γ/τ)
/// everything comes down to additions to the spheres' blocks and loads.
template <int Dim, class T>
class EffectJacobians {
    static constexpr int rotation = physics::rotation_dimension<Dim>;
    static constexpr int block = Dim + rotation;
    static constexpr int hinge_row = Dim + physics::bending_axis<Dim>;
    using Block = Eigen::Matrix<T, block, block>;
    using Column = Eigen::Matrix<T, block, 1>;
    using Rotations = Eigen::Matrix<T, rotation, rotation>;
    using Rotation = Eigen::Matrix<T, rotation, 1>;

  public:
    /// Evaluates the derivatives of all outer forces at `state` and `time`.
    void set_state(const physics::Chain<Dim, T>& chain, const T* state, const T& time) {
        const auto& layout = chain.layout();
        nodes_.resize(static_cast<std::size_t>(layout.sphere_count()));
        bending_.resize(static_cast<std::size_t>(layout.bond_count()));
        physics::BondExtras<Dim, T> below;
        for (int i = 0; i < layout.sphere_count(); ++i) {
            nodes_[static_cast<std::size_t>(i)] =
                chain.node_load(i, layout.sphere(state, i), below, time, true);
            if (i == layout.bond_count())
                break;
            below = chain.bond_extras(state, i, time, false);
            bending_[static_cast<std::size_t>(i)] =
                bending_projection(layout.geometry(state, i).direction);
        }
        if (layout.base_turns())
            clamp_ = chain.clamp_moment(state[layout.base_rotation_offset()],
                                        layout.sphere(state, 0).spin[physics::bending_axis<Dim>],
                                        time, true);
    }

    /// −γ times the derivative of sphere `i`'s outer force and moment by its velocity and spin.
    [[nodiscard]] Block node_resistance(std::size_t i, const T& gamma) const {
        Block added = Block::Constant(T(0.0));
        const physics::NodeLoad<Dim, T>& load = nodes_[i];
        for (int column = 0; column < Dim; ++column)
            for (int row = 0; row < Dim; ++row)
                added(row, column) =
                    -gamma * load.by_velocity[static_cast<std::size_t>(column)][row];
        added(1, 1) -= gamma * gamma * load.by_deflection;
        if (i == 0)
            added(hinge_row, hinge_row) -= gamma * (clamp_.by_rate + gamma * clamp_.by_rotation);
        return added;
    }

    /// ∂(moment of the branches of bond `j`)/∂(relative spin).
    [[nodiscard]] Rotations branch_response(const physics::Chain<Dim, T>& chain, int j,
                                            const T& gamma) const {
        T sum = T(0.0);
        for (const physics::MaxwellBranch<T>& branch : chain.model().branches)
            sum += branch.relative_stiffness / (T(1.0) + gamma / branch.relaxation_time);
        return (gamma * sum * chain.bond_coefficients(j).bending_stiffness) *
               bending_[static_cast<std::size_t>(j)];
    }

    /// γ times the branches' moments that follow from b alone.
    [[nodiscard]] Rotation branch_load(const physics::Chain<Dim, T>& chain, const T* b, int j,
                                       const T& gamma) const {
        Rotation sum = Rotation::Constant(T(0.0));
        for (int k = 0; k < chain.layout().branch_count(); ++k) {
            const auto moment = chain.layout().branch_moment(b, j, k);
            const T factor = gamma / (T(1.0) + gamma / relaxation_time(chain, k));
            for (int d = 0; d < rotation; ++d)
                sum(d) += factor * moment[d];
        }
        return sum;
    }

    /// Loads of the outer forces that follow from b alone.
    void add_node_loads(const physics::Chain<Dim, T>& chain, const T* b, const T& gamma,
                        std::vector<Column>& right_hand_side) const {
        const auto& layout = chain.layout();
        for (std::size_t i = 0; i < nodes_.size(); ++i)
            right_hand_side[i](1) +=
                gamma * nodes_[i].by_deflection * b[layout.sphere_offset(static_cast<int>(i)) + 1];
        if (layout.base_turns())
            right_hand_side[0](hinge_row) +=
                gamma * clamp_.by_rotation * b[layout.base_rotation_offset()];
    }

    /// Branch moments and clamp rotation from the solved velocities and spins.
    void recover(const physics::Chain<Dim, T>& chain, const T* b, const T& gamma,
                 const std::vector<Column>& solved, T* x) const {
        const auto& layout = chain.layout();
        for (int j = 0; j < layout.bond_count() && layout.branch_count() > 0; ++j) {
            const auto place = static_cast<std::size_t>(j);
            const Rotation relative = solved[place + 1].template tail<rotation>() -
                                      solved[place].template tail<rotation>();
            const Rotation bending = bending_[place].lazyProduct(relative);
            for (int k = 0; k < layout.branch_count(); ++k) {
                const auto& branch = chain.model().branches[static_cast<std::size_t>(k)];
                const T stiffness =
                    branch.relative_stiffness * chain.bond_coefficients(j).bending_stiffness;
                const T share = T(1.0) / (T(1.0) + gamma / branch.relaxation_time);
                auto moment = layout.branch_moment(b, j, k);
                for (int d = 0; d < rotation; ++d)
                    moment[d] = share * (moment[d] + gamma * stiffness * bending(d));
                layout.set_branch_moment(x, j, k, moment);
            }
        }
        if (layout.base_turns())
            x[layout.base_rotation_offset()] =
                b[layout.base_rotation_offset()] + gamma * solved[0](hinge_row);
    }

  private:
    [[nodiscard]] static T relaxation_time(const physics::Chain<Dim, T>& chain, int branch) {
        return chain.model().branches[static_cast<std::size_t>(branch)].relaxation_time;
    }

    /// Takes the twist out of a relative spin.
    [[nodiscard]] static Rotations bending_projection(const core::Vec<Dim, T>& direction) {
        Rotations projection;
        if constexpr (Dim == 2) {
            projection(0, 0) = T(1.0) + T(0.0) * direction[0];
        } else {
            for (int row = 0; row < 3; ++row)
                for (int column = 0; column < 3; ++column)
                    projection(row, column) =
                        T(row == column ? 1.0 : 0.0) - direction[row] * direction[column];
        }
        return projection;
    }

    std::vector<physics::NodeLoad<Dim, T>> nodes_; ///< (spheres)
    std::vector<Rotations> bending_;               ///< (bonds)
    physics::HingeMoment<T> clamp_;
};

} // namespace culm::integrate
