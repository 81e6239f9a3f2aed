// SPDX-License-Identifier: BSD-3-Clause
#include "integrate/bond_jacobian.hpp"
#include "integrate/modes.hpp"

#include <vector>

namespace culm::integrate {
namespace {

/// The degrees of freedom `wanted` (of axial 0, lateral 1, rotation 2) of every moving sphere, and
/// the clamp's rotation if it turns.
LinearisedChain straight_chain(const physics::Chain<2, double>& chain,
                               const std::vector<int>& wanted) {
    const LinearisedChain full = linearise(chain, chain.straight_state());
    std::vector<int> keep;
    if (chain.base_turns())
        keep.push_back(0);
    const int first = static_cast<int>(keep.size());
    for (int sphere = 0; sphere < chain.layout().bond_count(); ++sphere)
        for (const int freedom : wanted)
            keep.push_back(first + 3 * sphere + freedom);
    return {full.mass(keep), full.damping(keep, keep), full.stiffness(keep, keep)};
}

/// One bond's contributions to C and K: derivatives of the forces and torques on both spheres with
/// respect to the spheres' velocities and displacements, with the sign of a resistance.
template <int Dim>
struct BondMatrices {
    static constexpr int block = Dim + physics::rotation_dimension<Dim>;
    using Pair = Eigen::Matrix<double, 2 * block, 2 * block>;
    Pair damping;
    Pair stiffness;
};

/// Distributes the rows (force, torque_1, torque_2) of a bond to its spheres, which receive (force,
/// torque_1) and (−force, torque_2). The resistance is the negative of the result.
template <int Dim, class Rows>
typename BondMatrices<Dim>::Pair resistance(const Rows& rows) {
    constexpr int rotation = physics::rotation_dimension<Dim>;
    const auto force = rows.template topRows<Dim>();
    typename BondMatrices<Dim>::Pair pair;
    pair << -force, -rows.template middleRows<rotation>(Dim), force,
        -rows.template bottomRows<rotation>();
    return pair;
}

template <int Dim>
BondMatrices<Dim> bond_matrices(const BondJacobian<Dim>& jacobian) {
    using L = BondJacobianLayout<Dim>;
    constexpr int columns = 2 * BondMatrices<Dim>::block;
    // Columns of velocity and spins, rearranged to v1, ω1, v2, ω2 (relative velocity v2 − v1).
    Eigen::Matrix<double, L::outputs, columns> by_motion;
    const auto by_relative_velocity = jacobian.template middleCols<Dim>(L::velocity);
    by_motion << -by_relative_velocity, jacobian.template middleCols<L::rotation>(L::spin_1),
        by_relative_velocity, jacobian.template middleCols<L::rotation>(L::spin_2);

    // Small displacements change the local state of the bond by its rates' derivatives.
    const Eigen::Matrix<double, L::local_rate, columns> by_displacement =
        jacobian.template block<L::local_rate, L::local_size>(0, L::local) *
        by_motion.template bottomRows<L::local_size>();
    return {resistance<Dim>(by_motion.template topRows<L::local_rate>()),
            resistance<Dim>(by_displacement)};
}

/// Adds a bond's matrix where its first sphere is the `position`-th moving one; −1 when that
/// sphere is clamped.
template <int Dim>
void add_bond(const typename BondMatrices<Dim>::Pair& pair, int position, Eigen::MatrixXd& matrix) {
    constexpr int block = BondMatrices<Dim>::block;
    const Eigen::Index start = static_cast<Eigen::Index>(block) * position;
    if (position < 0)
        matrix.topLeftCorner(block, block) += pair.bottomRightCorner(block, block);
    else
        matrix.block(start, start, 2 * block, 2 * block) += pair;
}

/// Resistance of the air, users' forces, and the clamp's moment.
template <int Dim>
void add_outer_forces(const physics::Chain<Dim, double>& chain, const std::vector<double>& state,
                      int first, LinearisedChain& result) {
    constexpr int block = BondMatrices<Dim>::block;
    const auto& layout = chain.layout();
    for (int i = first; i < layout.sphere_count(); ++i) {
        const Eigen::Index place = static_cast<Eigen::Index>(block) * (i - first);
        const auto load = chain.node_load(i, layout.sphere(state.data(), i), {}, 0.0, true);
        for (int column = 0; column < Dim; ++column)
            for (int row = 0; row < Dim; ++row)
                result.damping(place + row, place + column) -=
                    load.by_velocity[static_cast<std::size_t>(column)][row];
        result.stiffness(place + 1, place + 1) -= load.by_deflection;
    }
    if (!chain.base_turns())
        return;
    constexpr int axis = physics::bending_axis<Dim>;
    const auto clamp = chain.clamp_moment(chain.base_state(state.data()), 0.0, true);
    result.damping(Dim + axis, Dim + axis) -= clamp.by_rate;
    result.stiffness(Dim + axis, Dim + axis) -= clamp.by_rotation;
    if (chain.model().slip) // small motions do not slip
        result.stiffness(Dim + axis, Dim + axis) += chain.model().hinge->stiffness;
}

/// Removes the degrees of freedom that a clamp that turns in the plane of bending still fixes.
template <int Dim>
LinearisedChain with_turning_base(const LinearisedChain& full) {
    constexpr int block = BondMatrices<Dim>::block;
    std::vector<int> keep{Dim + physics::bending_axis<Dim>};
    for (int k = block; k < static_cast<int>(full.mass.size()); ++k)
        keep.push_back(k);
    return {full.mass(keep), full.damping(keep, keep), full.stiffness(keep, keep)};
}

} // namespace

template <int Dim>
LinearisedChain linearise(const physics::Chain<Dim, double>& chain,
                          const std::vector<double>& state) {
    constexpr int block = BondMatrices<Dim>::block;
    const auto& layout = chain.layout();
    // Sphere 0 is included if it turns; its other degrees of freedom are removed at the end.
    const int first = chain.base_turns() ? 0 : chain.first_moving_sphere();
    const Eigen::Index dof = static_cast<Eigen::Index>(block) * (layout.sphere_count() - first);
    LinearisedChain result{Eigen::VectorXd(dof), Eigen::MatrixXd::Zero(dof, dof),
                           Eigen::MatrixXd::Zero(dof, dof)};
    for (Eigen::Index k = 0; k < dof; ++k) {
        const int sphere = first + static_cast<int>(k) / block;
        const Eigen::Index row = k % block;
        const auto& inertia = chain.sphere_inertia(sphere);
        result.mass(k) = row >= Dim ? inertia.moment : inertia.mass;
        if (row > 0 && row < Dim)
            result.mass(k) +=
                chain.air_at(sphere, layout.sphere(state.data(), sphere).velocity).mass;
    }

    BondDifferentiator<Dim> differentiator(chain);
    BondJacobian<Dim> jacobian;
    for (int j = 0; j < layout.bond_count(); ++j) {
        differentiator.evaluate(state.data(), j, 0.0, jacobian);
        const BondMatrices<Dim> bond = bond_matrices<Dim>(jacobian);
        add_bond<Dim>(bond.damping, j - first, result.damping);
        add_bond<Dim>(bond.stiffness, j - first, result.stiffness);
    }
    if (!chain.is_plain())
        add_outer_forces(chain, state, first, result);
    return chain.base_turns() && chain.first_moving_sphere() > 0 ? with_turning_base<Dim>(result)
                                                                 : result;
}

template LinearisedChain linearise<2>(const physics::Chain<2, double>&, const std::vector<double>&);
template LinearisedChain linearise<3>(const physics::Chain<3, double>&, const std::vector<double>&);

LinearisedChain linearise_transverse(const physics::StemParameters<double>& stem,
                                     const physics::BondLawOptions& law) {
    return linearise_transverse(physics::Chain<2, double>(stem, law));
}

LinearisedChain linearise_transverse(const physics::Chain<2, double>& chain) {
    return straight_chain(chain, {1, 2});
}

LinearisedChain linearise_axial(const physics::StemParameters<double>& stem,
                                const physics::BondLawOptions& law) {
    return straight_chain(physics::Chain<2, double>(stem, law), {0});
}

} // namespace culm::integrate
