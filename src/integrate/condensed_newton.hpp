// SPDX-License-Identifier: BSD-3-Clause
// The Newton system (I − γJ) δ = b of an implicit step, condensed to one small block per sphere.
#pragma once

#include "integrate/block_tridiagonal.hpp"
#include "integrate/bond_jacobian.hpp"

#include <algorithm>
#include <vector>

namespace culm::integrate {

/// The part of the system (I − γJ) δ = b that the bonds' own Jacobians do not contain. With
/// displacements δx = b_x + γ δv, clamp rotation δθ = b_θ + γ δω_0 and branch moments
///   δq = (b_q + γ g k_b δω_bend)/(1 + γ/τ)
/// it reduces to additions to the spheres' blocks and loads. The moment of a clamp that slips is
/// eliminated likewise, δz = (b_z + γ ż_ω δω_0)/(1 − γ ż_z). Air that moves with a sphere adds to
/// its mass, and M(v) a = F has the derivative F_v − a M_v.
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
    explicit EffectJacobians(const physics::Chain<Dim, T>& chain) : chain_(chain) {}

    /// Evaluates the derivatives of all outer forces at `state` and `time`.
    void set_state(const T* state, const T& time) {
        const auto& layout = chain_.layout();
        nodes_.resize(static_cast<std::size_t>(layout.sphere_count()));
        bending_.resize(static_cast<std::size_t>(layout.bond_count()));
        physics::BondExtras<Dim, T> below;
        for (int i = 0; i < layout.sphere_count(); ++i) {
            nodes_[static_cast<std::size_t>(i)] =
                chain_.node_load(i, layout.sphere(state, i), below, time, true);
            if (i == layout.bond_count())
                break;
            below = chain_.bond_extras(state, i, time, false);
            bending_[static_cast<std::size_t>(i)] =
                bending_projection(layout.geometry(state, i).direction);
        }
        if (layout.base_turns()) {
            const physics::BaseState<T> base = chain_.base_state(state);
            clamp_ = chain_.clamp_moment(base, time, true);
            if (const auto& slip = chain_.model().slip)
                slip_ = physics::slip_rate(*chain_.model().hinge, *slip, base.moment, base.rate);
        }
        if (chain_.model().air_mass)
            add_air(state, time);
    }

    /// Mass that resists motion of sphere `i` in direction `k`.
    [[nodiscard]] T mass(std::size_t i, int k) const {
        const T& own = chain_.sphere_inertia(static_cast<int>(i)).mass;
        return k == 0 || !chain_.model().air_mass ? own : own + air_[i];
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
            added(hinge_row, hinge_row) -=
                gamma * (clamp_.by_rate + gamma * clamp_.by_rotation) -
                gamma * gamma * slip_.by_rate / (T(1.0) - gamma * slip_.by_moment);
        return added;
    }

    /// ∂(moment of the branches of bond `j`)/∂(relative spin).
    [[nodiscard]] Rotations branch_response(int j, const T& gamma) const {
        T sum = T(0.0);
        for (const physics::MaxwellBranch<T>& branch : chain_.model().branches)
            sum += branch.relative_stiffness / (T(1.0) + gamma / branch.relaxation_time);
        return (gamma * sum * chain_.bond_coefficients(j).bending_stiffness) *
               bending_[static_cast<std::size_t>(j)];
    }

    /// γ times the branches' moments that follow from b alone.
    [[nodiscard]] Rotation branch_load(const T* b, int j, const T& gamma) const {
        Rotation sum = Rotation::Constant(T(0.0));
        for (int k = 0; k < chain_.layout().branch_count(); ++k) {
            const auto moment = chain_.layout().branch_moment(b, j, k);
            const auto& branch = chain_.model().branches[static_cast<std::size_t>(k)];
            const T factor = gamma / (T(1.0) + gamma / branch.relaxation_time);
            for (int d = 0; d < rotation; ++d)
                sum(d) += factor * moment[d];
        }
        return sum;
    }

    /// Loads of the outer forces that follow from b alone.
    void add_node_loads(const T* b, const T& gamma, std::vector<Column>& right_hand_side) const {
        const auto& layout = chain_.layout();
        for (std::size_t i = 0; i < nodes_.size(); ++i)
            right_hand_side[i](1) +=
                gamma * nodes_[i].by_deflection * b[layout.sphere_offset(static_cast<int>(i)) + 1];
        if (layout.base_turns())
            right_hand_side[0](hinge_row) +=
                gamma * clamp_.by_rotation * b[layout.base_rotation_offset()];
        if (layout.base_slips())
            right_hand_side[0](hinge_row) -=
                gamma * b[layout.base_moment_offset()] / (T(1.0) - gamma * slip_.by_moment);
    }

    /// Branch moments and clamp rotation from the solved velocities and spins.
    void recover(const T* b, const T& gamma, const std::vector<Column>& solved, T* x) const {
        const auto& layout = chain_.layout();
        for (int j = 0; j < layout.bond_count() && layout.branch_count() > 0; ++j) {
            const auto place = static_cast<std::size_t>(j);
            const Rotation relative = solved[place + 1].template tail<rotation>() -
                                      solved[place].template tail<rotation>();
            const Rotation bending = bending_[place].lazyProduct(relative);
            for (int k = 0; k < layout.branch_count(); ++k) {
                const auto& branch = chain_.model().branches[static_cast<std::size_t>(k)];
                const T stiffness =
                    branch.relative_stiffness * chain_.bond_coefficients(j).bending_stiffness;
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
        if (layout.base_slips())
            x[layout.base_moment_offset()] =
                (b[layout.base_moment_offset()] + gamma * slip_.by_rate * solved[0](hinge_row)) /
                (T(1.0) - gamma * slip_.by_moment);
    }

  private:
    void add_air(const T* state, const T& time) {
        const auto& layout = chain_.layout();
        rate_.resize(layout.size());
        air_.resize(nodes_.size());
        chain_.evaluate_rate(state, rate_.data(), time);
        for (std::size_t i = 0; i < nodes_.size(); ++i) {
            const int sphere = static_cast<int>(i);
            const core::Vec<Dim, T> velocity = layout.sphere(state, sphere).velocity;
            const core::Vec<Dim, T> acceleration = layout.sphere(rate_.data(), sphere).velocity;
            const physics::MovedAir<T> air = chain_.air_at(sphere, velocity);
            air_[i] = air.mass;
            for (int column = 1; column < Dim; ++column)
                for (int row = 1; row < Dim; ++row)
                    nodes_[i].by_velocity[static_cast<std::size_t>(column)][row] -=
                        acceleration[row] * air.slope * velocity[column];
        }
    }

    /// Removes the twist from a relative spin.
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

    const physics::Chain<Dim, T>& chain_;
    std::vector<physics::NodeLoad<Dim, T>> nodes_; ///< (spheres)
    std::vector<Rotations> bending_;               ///< (bonds)
    physics::HingeMoment<T> clamp_;
    physics::SlipRate<T> slip_{T(0.0), T(0.0), T(0.0)};
    std::vector<T> air_;  ///< (spheres) that moves with them, kg
    std::vector<T> rate_; ///< in the chain's layout
};

/// Positions (ẋ = v) and the local states of the bonds (history and geometry z, with rates ρ) are
/// eliminated exactly. The condensed system couples velocity and spin of neighbouring spheres: 3×3
/// blocks in the plane, 6×6 in space. With relative velocity u and spins ω each bond gives
///   δz = P [b_z + γ (ρ_u δu + ρ_ω δω)],   P = (I − γ ρ_z)⁻¹;
/// subscripts are derivatives. The Maxwell branches of effects and the rotation of a clamp that
/// turns are eliminated likewise; J neglects that the branches' moments turn with the bond.
template <int Dim, class T = double>
class CondensedNewton {
    using Layout = BondJacobianLayout<Dim>;
    static constexpr int rotation = Layout::rotation;
    static constexpr int local = Layout::local_size;
    static constexpr int forces = Dim + 2 * rotation;
    static constexpr int block = Dim + rotation;
    using Blocks = BlockTridiagonal<block, T>;

  public:
    explicit CondensedNewton(const physics::Chain<Dim, T>& chain)
        : chain_(chain), differentiator_(chain),
          jacobians_(static_cast<std::size_t>(chain.layout().bond_count())),
          condensed_(jacobians_.size()), blocks_(chain.layout().sphere_count()),
          right_hand_side_(blocks_.block_count()), effects_(chain) {}

    /// Evaluates all Jacobians at `state` and `time`.
    void set_state(const T* state, const T& time = T(0.0)) {
        for (int j = 0; j < chain_.layout().bond_count(); ++j)
            differentiator_.evaluate(state, j, time, jacobians_[static_cast<std::size_t>(j)]);
        if (!chain_.is_plain())
            effects_.set_state(state, time);
    }

    /// Condenses and factorises I − γJ with the current Jacobians; false if it is singular.
    [[nodiscard]] bool factorise(const T& gamma);

    /// Solves (I − γJ) x = b; both are in the chain's state layout and may be the same array.
    void solve(const T* b, T* x) {
        fill_right_hand_side(b);
        blocks_.solve(right_hand_side_);
        recover(b, x);
    }

  private:
    using Local = Eigen::Matrix<T, local, 1>;

    /// The condensed matrices of one bond.
    struct CondensedBond {
        Eigen::Matrix<T, forces, local> from_local;           ///< γ f_z P, times b_z
        Eigen::Matrix<T, local, local> local_from_local;      ///< P
        Eigen::Matrix<T, local, 2 * block> local_from_motion; ///< γ P (ρ_u, ρ_ω)
    };

    void condense(std::size_t j);
    void fix_clamped_rows();
    void fill_right_hand_side(const T* b);
    void recover(const T* b, T* x);

    /// Mass or moment of inertia of sphere `i` in row `row` of its block.
    [[nodiscard]] T inertia(std::size_t i, int row) const {
        return row < Dim ? effects_.mass(i, row)
                         : chain_.sphere_inertia(static_cast<int>(i)).moment;
    }

    /// Is row `row` of sphere 0's block an equation of motion?
    [[nodiscard]] bool base_moves_in(int row) const {
        return chain_.first_moving_sphere() == 0 ||
               (chain_.base_turns() && row == Dim + physics::bending_axis<Dim>);
    }

    /// History and geometry of bond `j` in an array of the chain's layout, as one vector.
    [[nodiscard]] Local local_part(const T* array, std::size_t j) const {
        const auto bond = static_cast<int>(j);
        Local part;
        std::copy_n(array + chain_.layout().bond_offset(bond), 2 * rotation, part.data());
        std::copy_n(array + chain_.layout().geometry_offset(bond), 1 + Dim,
                    part.data() + 2 * rotation);
        return part;
    }

    const physics::Chain<Dim, T>& chain_;
    BondDifferentiator<Dim, T> differentiator_;
    std::vector<BondJacobian<Dim, T>> jacobians_;
    std::vector<CondensedBond> condensed_;
    Blocks blocks_;
    std::vector<typename Blocks::Column> right_hand_side_;
    EffectJacobians<Dim, T> effects_;
    T gamma_ = T(0.0);
};

template <int Dim, class T>
[[gnu::flatten]] void CondensedNewton<Dim, T>::condense(std::size_t j) {
    using L = Layout;
    const BondJacobian<Dim, T>& jacobian = jacobians_[j];
    CondensedBond& bond = condensed_[j];

    const auto f_u = jacobian.template block<forces, Dim>(0, L::velocity);
    const auto f_w = jacobian.template block<forces, 2 * rotation>(0, L::spin_1);
    const auto f_z = jacobian.template block<forces, local>(0, L::local);
    const auto rho_u = jacobian.template block<local, Dim>(L::local_rate, L::velocity);
    const auto rho_w = jacobian.template block<local, 2 * rotation>(L::local_rate, L::spin_1);
    const auto rho_z = jacobian.template block<local, local>(L::local_rate, L::local);

    Eigen::Matrix<T, local, local> inverse = -gamma_ * rho_z;
    for (int k = 0; k < local; ++k)
        inverse(k, k) += T(1.0);
    invert_in_place(inverse);
    bond.local_from_local = inverse;

    const Eigen::Matrix<T, local, Dim> from_velocity = inverse.lazyProduct((gamma_ * rho_u).eval());
    const Eigen::Matrix<T, local, 2 * rotation> from_spin =
        inverse.lazyProduct((gamma_ * rho_w).eval());
    // Columns in the order v1, ω1, v2, ω2; the relative velocity is v2 − v1.
    bond.local_from_motion << -from_velocity, from_spin.template leftCols<rotation>(),
        from_velocity, from_spin.template rightCols<rotation>();

    Eigen::Matrix<T, forces, 2 * block> response;
    response << -f_u, f_w.template leftCols<rotation>(), f_u, f_w.template rightCols<rotation>();
    response += f_z.lazyProduct(bond.local_from_motion);
    if (!chain_.is_plain()) {
        const auto branches = effects_.branch_response(static_cast<int>(j), gamma_);
        response.template block<rotation, rotation>(Dim, Dim) -= branches;
        response.template block<rotation, rotation>(Dim, block + Dim) += branches;
        response.template block<rotation, rotation>(Dim + rotation, Dim) += branches;
        response.template block<rotation, rotation>(Dim + rotation, block + Dim) -= branches;
    }
    bond.from_local = (gamma_ * f_z).eval().lazyProduct(inverse);

    // Sphere 1 receives (force, torque_1), sphere 2 (−force, torque_2).
    Eigen::Matrix<T, block, 2 * block> on_1;
    Eigen::Matrix<T, block, 2 * block> on_2;
    on_1 << response.template topRows<Dim>(), response.template middleRows<rotation>(Dim);
    on_2 << -response.template topRows<Dim>(), response.template bottomRows<rotation>();
    blocks_.diagonal(j) -= gamma_ * on_1.template leftCols<block>();
    blocks_.upper(j) = -gamma_ * on_1.template rightCols<block>();
    blocks_.lower(j + 1) = -gamma_ * on_2.template leftCols<block>();
    blocks_.diagonal(j + 1) = -gamma_ * on_2.template rightCols<block>();
}

template <int Dim, class T>
void CondensedNewton<Dim, T>::fix_clamped_rows() {
    for (int row = 0; row < block; ++row) {
        if (base_moves_in(row))
            continue;
        blocks_.diagonal(0).row(row).setConstant(T(0.0));
        blocks_.upper(0).row(row).setConstant(T(0.0));
        blocks_.diagonal(0)(row, row) = T(1.0);
    }
}

template <int Dim, class T>
bool CondensedNewton<Dim, T>::factorise(const T& gamma) {
    gamma_ = gamma;
    blocks_.diagonal(0).setConstant(T(0.0));
    for (std::size_t j = 0; j < jacobians_.size(); ++j)
        condense(j);
    for (std::size_t i = 0; i < blocks_.block_count(); ++i) {
        for (int k = 0; k < block; ++k)
            blocks_.diagonal(i)(k, k) += inertia(i, k);
        if (!chain_.is_plain())
            blocks_.diagonal(i) += effects_.node_resistance(i, gamma_);
    }
    fix_clamped_rows();
    return blocks_.factorise();
}

template <int Dim, class T>
[[gnu::flatten]] void CondensedNewton<Dim, T>::fill_right_hand_side(const T* b) {
    const auto& layout = chain_.layout();
    for (std::size_t i = 0; i < blocks_.block_count(); ++i) {
        const T* const sphere = b + layout.sphere_offset(static_cast<int>(i));
        for (int k = 0; k < block; ++k)
            right_hand_side_[i](k) = inertia(i, k) * sphere[Dim + k];
    }
    for (std::size_t j = 0; j < condensed_.size(); ++j) {
        Eigen::Matrix<T, forces, 1> load = condensed_[j].from_local.lazyProduct(local_part(b, j));
        if (!chain_.is_plain()) {
            const auto branches = effects_.branch_load(b, static_cast<int>(j), gamma_);
            load.template segment<rotation>(Dim) += branches;
            load.template tail<rotation>() -= branches;
        }
        right_hand_side_[j].template head<Dim>() += load.template head<Dim>();
        right_hand_side_[j].template tail<rotation>() += load.template segment<rotation>(Dim);
        right_hand_side_[j + 1].template head<Dim>() -= load.template head<Dim>();
        right_hand_side_[j + 1].template tail<rotation>() += load.template tail<rotation>();
    }
    if (!chain_.is_plain())
        effects_.add_node_loads(b, gamma_, right_hand_side_);
    for (int row = 0; row < block; ++row)
        if (!base_moves_in(row))
            right_hand_side_[0](row) =
                b[layout.sphere_offset(0) + Dim + static_cast<std::size_t>(row)];
}

template <int Dim, class T>
[[gnu::flatten]] void CondensedNewton<Dim, T>::recover(const T* b, T* x) {
    const auto& layout = chain_.layout();
    for (std::size_t j = 0; j < condensed_.size(); ++j) {
        const CondensedBond& bond = condensed_[j];
        const Local increment =
            bond.local_from_local.lazyProduct(local_part(b, j)) +
            bond.local_from_motion.template leftCols<block>().lazyProduct(right_hand_side_[j]) +
            bond.local_from_motion.template rightCols<block>().lazyProduct(right_hand_side_[j + 1]);
        std::copy_n(increment.data(), 2 * rotation, x + layout.bond_offset(static_cast<int>(j)));
        std::copy_n(increment.data() + 2 * rotation, 1 + Dim,
                    x + layout.geometry_offset(static_cast<int>(j)));
    }
    if (!chain_.is_plain())
        effects_.recover(b, gamma_, right_hand_side_, x);
    for (std::size_t i = 0; i < blocks_.block_count(); ++i) {
        const std::size_t offset = layout.sphere_offset(static_cast<int>(i));
        const bool moves = static_cast<int>(i) >= chain_.first_moving_sphere();
        for (std::size_t k = 0; k < Dim; ++k)
            x[offset + k] =
                moves ? b[offset + k] + gamma_ * right_hand_side_[i](static_cast<Eigen::Index>(k))
                      : b[offset + k];
        for (std::size_t k = 0; k < block; ++k)
            x[offset + Dim + k] = right_hand_side_[i](static_cast<Eigen::Index>(k));
    }
}

} // namespace culm::integrate
