// SPDX-License-Identifier: BSD-3-Clause
// Chains in an arbitrary, well-bent state of motion, for tests of the force law.
#pragma once

#include "physics/chain.hpp"

#include <random>
#include <vector>

namespace culm::tests {

/// A state near the straight one in which every number is random: displacements of a tenth of the
/// bond length, velocities and spins of a vibrating stem, and bond histories of the size that
/// such displacements cause, normal to the bond where required. The clamped sphere is at rest.
template <int Dim>
std::vector<double> random_state(const physics::Chain<Dim, double>& chain, unsigned seed) {
    std::mt19937_64 engine(seed);
    std::uniform_real_distribution<double> stir(-1.0, 1.0);
    const auto& layout = chain.layout();
    const auto& bond = chain.bond_coefficients();
    std::vector<double> state = chain.straight_state();
    for (int i = chain.first_moving_sphere(); i < layout.sphere_count(); ++i) {
        auto sphere = layout.sphere(state.data(), i);
        for (int d = 0; d < Dim; ++d) {
            sphere.position[d] += 0.1 * bond.length * stir(engine);
            sphere.velocity[d] = stir(engine);
        }
        for (auto& component : sphere.spin.component)
            component = 300.0 * stir(engine);
        layout.set_sphere(state.data(), i, sphere);
    }
    for (int j = 0; j < layout.bond_count(); ++j) {
        const auto motion = chain.motion_between(layout.sphere(state.data(), j),
                                                 layout.sphere(state.data(), j + 1));
        const physics::BondFrame<Dim, double> frame(motion.separation);
        auto history = layout.bond(state.data(), j);
        for (auto& component : history.shear_force.component)
            component = 0.01 * bond.shear_stiffness * bond.length * stir(engine);
        for (auto& component : history.moment.component)
            component = 0.01 * bond.bending_stiffness * stir(engine);
        history.shear_force = frame.turned_shear(history.shear_force);
        layout.set_bond(state.data(), j, history);
    }
    layout.set_geometry(state.data());
    return state;
}

} // namespace culm::tests
