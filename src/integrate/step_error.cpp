// SPDX-License-Identifier: BSD-3-Clause
#include "integrate/step_error.hpp"

#include <limits>
#include <numbers>

#include <Eigen/LU>

namespace culm::integrate {
namespace {

using Complex = std::complex<double>;

/// Vector of the null space of a nearly singular matrix, by inverse iteration. Convergence is
/// immediate: the matrix is singular up to the rounding of its eigenvalue.
Eigen::VectorXcd null_vector(const Eigen::MatrixXcd& matrix, const Eigen::VectorXd& mass) {
    const Eigen::PartialPivLU<Eigen::MatrixXcd> solver(matrix);
    Eigen::VectorXcd vector = Eigen::VectorXcd::Ones(matrix.rows());
    for (int iteration = 0; iteration < 4; ++iteration) {
        vector = solver.solve(mass.asDiagonal() * vector);
        vector.normalize();
    }
    return vector;
}

} // namespace

std::optional<FirstModeStepError> FirstModeStepError::of(const LinearisedChain& chain) {
    const std::vector<VibrationMode> modes = vibration_modes(chain, 1);
    if (modes.empty())
        return std::nullopt;
    FirstModeStepError mode;
    mode.eigenvalue_ =
        Complex(modes.front().decay_rate, 2.0 * std::numbers::pi * modes.front().frequency);
    const Complex lambda = mode.eigenvalue_;
    const Eigen::MatrixXcd damping = chain.damping.cast<Complex>();
    const Eigen::MatrixXcd pencil = lambda * lambda * Eigen::MatrixXcd(chain.mass.asDiagonal()) +
                                    lambda * damping + chain.stiffness.cast<Complex>();
    const Eigen::VectorXcd right = null_vector(pencil, chain.mass);
    const Eigen::VectorXcd left = null_vector(pencil.transpose(), chain.mass);
    const Complex mass_form = left.transpose() * chain.mass.asDiagonal() * right;
    const Complex damping_form = left.transpose() * damping * right;
    const Complex slope = 2.0 * lambda * mass_form + damping_form;
    mode.mass_ = mass_form / slope;
    mode.damping_ = damping_form / slope;
    return mode;
}

StepError FirstModeStepError::at(double step) const {
    const Complex lambda = eigenvalue_;
    const Complex z = lambda * step;
    // (2 sinh(z/2)/h)² − λ² and (1 − e^(−z))/h − λ as series: their differences would cancel.
    const Complex of_mass = lambda * lambda * z * z * (1.0 / 12.0 + z * z / 360.0);
    const Complex of_damping = -lambda * z * (0.5 - z / 6.0 + z * z / 24.0 - z * z * z / 120.0);
    const Complex shift = -(of_mass * mass_ + of_damping * damping_);
    const double of_frequency = shift.imag() / lambda.imag();
    const double of_decay = lambda.real() < 0.0 ? shift.real() / lambda.real()
                                                : std::numeric_limits<double>::quiet_NaN();
    return {of_decay - of_frequency, of_frequency};
}

} // namespace culm::integrate
