// SPDX-License-Identifier: BSD-3-Clause
// A chain that vibrates in a single mode; at small amplitude its motion is known exactly.
#pragma once

#include "integrate/modes.hpp"

#include <complex>
#include <vector>

#include <Eigen/Dense>

namespace culm::tests {

/// The state Re(φ e^{λt}) at t = 0 of the slowest vibrating mode of the straight planar chain,
/// scaled to the tip deflection `amplitude` (m), and its eigenvalue. The eigenvector is found by
/// inverse iteration on λ²M + λC + K, independently of the code under test's own eigenvalues.
struct ModalState {
    std::complex<double> eigenvalue;
    std::vector<double> state;
};

inline ModalState first_mode_state(const physics::Chain<2, double>& chain,
                                   const integrate::LinearisedChain& transverse, double amplitude) {
    const Eigen::Index n = transverse.mass.size();
    const auto guess = integrate::vibration_modes(transverse, 1).front();
    std::complex<double> lambda(guess.decay_rate, 2.0 * 3.14159265358979323846 * guess.frequency);
    Eigen::VectorXcd shape = Eigen::VectorXcd::Ones(n);
    const Eigen::MatrixXcd pencil =
        lambda * lambda * Eigen::MatrixXcd(transverse.mass.asDiagonal()) +
        lambda * transverse.damping.cast<std::complex<double>>() +
        transverse.stiffness.cast<std::complex<double>>();
    const Eigen::PartialPivLU<Eigen::MatrixXcd> solver(pencil);
    for (int iteration = 0; iteration < 4; ++iteration) {
        shape = solver.solve(transverse.mass.asDiagonal() * shape);
        shape /= shape(n - 2); // the tip's lateral displacement
    }

    const auto& layout = chain.layout();
    ModalState result{lambda, chain.straight_state()};
    std::vector<std::complex<double>> lateral(static_cast<std::size_t>(layout.sphere_count()));
    std::vector<std::complex<double>> angle(lateral.size());
    for (int i = 1; i < layout.sphere_count(); ++i) {
        const auto k = static_cast<std::size_t>(i);
        lateral[k] = amplitude * shape(2 * (i - 1));
        angle[k] = amplitude * shape(2 * (i - 1) + 1);
        auto sphere = layout.sphere(result.state.data(), i);
        sphere.position[1] = lateral[k].real();
        sphere.velocity[1] = (lambda * lateral[k]).real();
        sphere.spin[0] = (lambda * angle[k]).real();
        layout.set_sphere(result.state.data(), i, sphere);
    }
    const auto& bond = chain.bond_coefficients();
    for (int j = 0; j < layout.bond_count(); ++j) {
        const auto k = static_cast<std::size_t>(j);
        physics::BondState<2, double> history;
        history.shear_force[0] =
            bond.shear_stiffness *
            (lateral[k + 1] - lateral[k] -
             bond.span * (bond.share_1 * angle[k] + bond.share_2 * angle[k + 1]))
                .real();
        history.moment[0] = bond.bending_stiffness * (angle[k + 1] - angle[k]).real();
        layout.set_bond(result.state.data(), j, history);
    }
    layout.set_geometry(result.state.data());
    return result;
}

} // namespace culm::tests
