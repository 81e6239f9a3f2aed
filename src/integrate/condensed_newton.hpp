// SPDX-License-Identifier: BSD-3-Clause
// The Newton system (I − γJ) δ = b of an implicit step, condensed to one small block per sphere.
#pragma once

#include "integrate/block_tridiagonal.hpp"
#include "integrate/bond_jacobian.hpp"

#include <vector>

namespace culm::integrate {

/// Positions (ẋ = v) and bond histories (whose rates are local to a bond) are eliminated exactly;
/// what remains couples velocity and spin of neighbouring spheres: 3×3 blocks in the plane, 6×6 in
/// space. With δd = Δb_x + γ δu the separation's and δq the history's increment, each bond gives
///   δq = P [b_q + γ ρ_d Δb_x + γ ((γρ_d + ρ_u) δu + ρ_ω δω)],   P = (I − γ ρ_q)⁻¹,
/// where ρ are the history's rates, u the relative velocity, and subscripts are derivatives.
template <int Dim>
class CondensedNewton {
    using Layout = BondJacobianLayout<Dim>;
    static constexpr int rotation = Layout::rotation;
    static constexpr int history = Layout::history_size;
    static constexpr int block = Dim + rotation;
    using Blocks = BlockTridiagonal<block>;

  public:
    explicit CondensedNewton(const physics::Chain<Dim, double>& chain)
        : chain_(chain), differentiator_(chain.bond_coefficients(), chain.law()),
          jacobians_(static_cast<std::size_t>(chain.layout().bond_count())),
          condensed_(jacobians_.size()), blocks_(chain.layout().sphere_count()),
          right_hand_side_(blocks_.block_count()) {}

    /// Evaluates the bonds' Jacobians at `state`.
    void set_state(const double* state) {
        const auto& layout = chain_.layout();
        for (int j = 0; j < layout.bond_count(); ++j) {
            const auto motion =
                chain_.motion_between(layout.sphere(state, j), layout.sphere(state, j + 1));
            differentiator_.evaluate(motion, layout.bond(state, j),
                                     jacobians_[static_cast<std::size_t>(j)]);
        }
    }

    [[nodiscard]] const std::vector<BondJacobian<Dim>>& bond_jacobians() const {
        return jacobians_;
    }

    /// Condenses and factorises I − γJ with the Jacobians at hand; false if that is singular.
    [[nodiscard]] bool factorise(double gamma) {
        gamma_ = gamma;
        blocks_.set_zero();
        for (std::size_t j = 0; j < jacobians_.size(); ++j) {
            condense(j);
            add_to_blocks(j);
        }
        const physics::SphereInertia<double>& inertia = chain_.sphere_inertia();
        for (std::size_t i = 0; i < blocks_.block_count(); ++i) {
            if (static_cast<int>(i) < chain_.first_moving_sphere()) {
                blocks_.diagonal(i).setIdentity();
                blocks_.upper(i).setZero();
                continue;
            }
            for (int k = 0; k < block; ++k)
                blocks_.diagonal(i)(k, k) += k < Dim ? inertia.mass : inertia.moment;
        }
        return blocks_.factorise();
    }

    /// Solves (I − γJ) x = b; both are in the chain's state layout and may be the same array.
    void solve(const double* b, double* x) {
        fill_right_hand_side(b);
        blocks_.solve(right_hand_side_);
        recover(b, x);
    }

  private:
    /// What condensation leaves of one bond.
    struct CondensedBond {
        /// d(force, torque_1, torque_2)/d(velocity and spin of sphere 1, of sphere 2).
        Eigen::Matrix<double, Dim + 2 * rotation, 2 * block> response;
        Eigen::Matrix<double, Dim + 2 * rotation, Dim> from_positions;   ///< times Δb_x
        Eigen::Matrix<double, Dim + 2 * rotation, history> from_history; ///< times b_q
        Eigen::Matrix<double, history, history> history_from_history;    ///< P
        Eigen::Matrix<double, history, Dim> history_from_positions;      ///< γ P ρ_d
        Eigen::Matrix<double, history, 2 * block> history_from_motion; ///< γ P (γρ_d+ρ_u, ρ_ω)
    };

    void condense(std::size_t j);
    void add_to_blocks(std::size_t j);
    void fill_right_hand_side(const double* b);
    void recover(const double* b, double* x);

    const physics::Chain<Dim, double>& chain_;
    BondDifferentiator<Dim> differentiator_;
    std::vector<BondJacobian<Dim>> jacobians_;
    std::vector<CondensedBond> condensed_;
    Blocks blocks_;
    std::vector<typename Blocks::Column> right_hand_side_;
    double gamma_ = 0.0;
};

template <int Dim>
void CondensedNewton<Dim>::condense(std::size_t j) {
    using L = Layout;
    constexpr int forces = Dim + 2 * rotation;
    const BondJacobian<Dim>& jacobian = jacobians_[j];
    CondensedBond& bond = condensed_[j];

    const auto f_d = jacobian.template block<forces, Dim>(0, L::separation);
    const auto f_u = jacobian.template block<forces, Dim>(0, L::velocity);
    const auto f_w = jacobian.template block<forces, 2 * rotation>(0, L::spin_1);
    const auto f_q = jacobian.template block<forces, history>(0, L::history);
    const auto rho_d = jacobian.template block<history, Dim>(L::history_rate, L::separation);
    const auto rho_u = jacobian.template block<history, Dim>(L::history_rate, L::velocity);
    const auto rho_w = jacobian.template block<history, 2 * rotation>(L::history_rate, L::spin_1);
    const auto rho_q = jacobian.template block<history, history>(L::history_rate, L::history);

    using HistoryBlock = Eigen::Matrix<double, history, history>;
    const HistoryBlock implicit = HistoryBlock::Identity() - gamma_ * rho_q;
    bond.history_from_history = Eigen::PartialPivLU<HistoryBlock>(implicit).inverse();
    bond.history_from_positions.noalias() = gamma_ * (bond.history_from_history * rho_d);

    const Eigen::Matrix<double, history, Dim> from_velocity =
        gamma_ * (bond.history_from_history * (gamma_ * rho_d + rho_u));
    const Eigen::Matrix<double, history, 2 * rotation> from_spin =
        gamma_ * (bond.history_from_history * rho_w);
    // Columns in the order v1, ω1, v2, ω2; the relative velocity is v2 − v1.
    bond.history_from_motion << -from_velocity, from_spin.template leftCols<rotation>(),
        from_velocity, from_spin.template rightCols<rotation>();

    bond.from_history.noalias() = f_q * bond.history_from_history;
    bond.from_positions.noalias() = f_d + f_q * bond.history_from_positions;
    const Eigen::Matrix<double, forces, Dim> force_from_velocity = gamma_ * f_d + f_u;
    bond.response << -force_from_velocity, f_w.template leftCols<rotation>(), force_from_velocity,
        f_w.template rightCols<rotation>();
    bond.response.noalias() += f_q * bond.history_from_motion;
}

template <int Dim>
void CondensedNewton<Dim>::add_to_blocks(std::size_t j) {
    const auto& response = condensed_[j].response;
    // Sphere 1 receives (force, torque_1), sphere 2 (−force, torque_2).
    Eigen::Matrix<double, block, 2 * block> on_1;
    Eigen::Matrix<double, block, 2 * block> on_2;
    on_1 << response.template topRows<Dim>(), response.template middleRows<rotation>(Dim);
    on_2 << -response.template topRows<Dim>(), response.template bottomRows<rotation>();
    blocks_.diagonal(j) -= gamma_ * on_1.template leftCols<block>();
    blocks_.upper(j) -= gamma_ * on_1.template rightCols<block>();
    blocks_.lower(j + 1) -= gamma_ * on_2.template leftCols<block>();
    blocks_.diagonal(j + 1) -= gamma_ * on_2.template rightCols<block>();
}

template <int Dim>
void CondensedNewton<Dim>::fill_right_hand_side(const double* b) {
    const auto& layout = chain_.layout();
    const physics::SphereInertia<double>& inertia = chain_.sphere_inertia();
    for (std::size_t i = 0; i < blocks_.block_count(); ++i) {
        const double* sphere = b + layout.sphere_offset(static_cast<int>(i));
        const bool moves = static_cast<int>(i) >= chain_.first_moving_sphere();
        for (int k = 0; k < block; ++k) {
            const double weight = !moves ? 1.0 : k < Dim ? inertia.mass : inertia.moment;
            right_hand_side_[i](k) = weight * sphere[Dim + k];
        }
    }
    for (std::size_t j = 0; j < condensed_.size(); ++j) {
        const int bond_index = static_cast<int>(j);
        const Eigen::Map<const Eigen::Matrix<double, Dim, 1>> x1(b +
                                                                 layout.sphere_offset(bond_index));
        const Eigen::Map<const Eigen::Matrix<double, Dim, 1>> x2(
            b + layout.sphere_offset(bond_index + 1));
        const Eigen::Map<const Eigen::Matrix<double, history, 1>> q(b +
                                                                    layout.bond_offset(bond_index));
        const Eigen::Matrix<double, Dim + 2 * rotation, 1> load =
            gamma_ * (condensed_[j].from_positions * (x2 - x1) + condensed_[j].from_history * q);
        if (bond_index >= chain_.first_moving_sphere()) {
            right_hand_side_[j].template head<Dim>() += load.template head<Dim>();
            right_hand_side_[j].template tail<rotation>() += load.template segment<rotation>(Dim);
        }
        right_hand_side_[j + 1].template head<Dim>() -= load.template head<Dim>();
        right_hand_side_[j + 1].template tail<rotation>() += load.template tail<rotation>();
    }
}

template <int Dim>
void CondensedNewton<Dim>::recover(const double* b, double* x) {
    const auto& layout = chain_.layout();
    using Column = Eigen::Matrix<double, Dim, 1>;
    for (std::size_t j = 0; j < condensed_.size(); ++j) {
        const int bond_index = static_cast<int>(j);
        const Column gap = Eigen::Map<const Column>(b + layout.sphere_offset(bond_index + 1)) -
                           Eigen::Map<const Column>(b + layout.sphere_offset(bond_index));
        Eigen::Map<const Eigen::Matrix<double, history, 1>> q(b + layout.bond_offset(bond_index));
        Eigen::Matrix<double, 2 * block, 1> motion;
        motion << right_hand_side_[j], right_hand_side_[j + 1];
        const Eigen::Matrix<double, history, 1> increment =
            condensed_[j].history_from_history * q + condensed_[j].history_from_positions * gap +
            condensed_[j].history_from_motion * motion;
        Eigen::Map<Eigen::Matrix<double, history, 1>>(x + layout.bond_offset(bond_index)) =
            increment;
    }
    for (std::size_t i = 0; i < blocks_.block_count(); ++i) {
        const std::size_t offset = layout.sphere_offset(static_cast<int>(i));
        const bool moves = static_cast<int>(i) >= chain_.first_moving_sphere();
        for (int k = 0; k < Dim; ++k)
            x[offset + static_cast<std::size_t>(k)] =
                b[offset + static_cast<std::size_t>(k)] +
                (moves ? gamma_ * right_hand_side_[i](k) : 0.0);
        for (int k = 0; k < block; ++k)
            x[offset + static_cast<std::size_t>(Dim + k)] = right_hand_side_[i](k);
    }
}

} // namespace culm::integrate
