// SPDX-License-Identifier: BSD-3-Clause
#include "integrate/slowest_mode.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/LU>

namespace culm::integrate {
namespace {

using Complex = std::complex<double>;

constexpr int most_iterations = 12;
constexpr double tolerance = 1e-7; ///< of the last change of λ, relative; the error is its square
/// λ may move this far from iω of the undamped mode, relative: it would else be another mode.
constexpr double farthest = 0.5;

/// In units of the undamped mode's angular frequency ω, with displacements and rotations scaled
/// alike: (z²M + zC/ω + K/ω²) u = 0.
std::optional<Complex> newton(const LinearisedChain& chain, double angular_frequency) {
    const Eigen::VectorXd scale = chain.mass.cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXcd stiffness =
        (scale.asDiagonal() * chain.stiffness * scale.asDiagonal() / std::pow(angular_frequency, 2))
            .cast<Complex>();
    const Eigen::MatrixXcd damping =
        (scale.asDiagonal() * chain.damping * scale.asDiagonal() / angular_frequency)
            .cast<Complex>();
    Complex z(0.0, 1.0);
    Eigen::VectorXcd shape = Eigen::VectorXcd::Ones(stiffness.rows());
    Eigen::VectorXcd normal = shape; // of the shape's length, kept at 1
    for (int k = 0; k < most_iterations; ++k) {
        Eigen::MatrixXcd pencil = stiffness + z * damping;
        pencil.diagonal().array() += z * z;
        const Eigen::VectorXcd slope = damping * shape + 2.0 * z * shape;
        const Eigen::VectorXcd next = pencil.partialPivLu().solve(slope);
        const Complex change = normal.dot(shape) / normal.dot(next);
        if (!std::isfinite(std::abs(change)))
            return std::nullopt;
        shape = next / next.norm();
        normal = shape;
        // The first steps turn the shape into the mode's.
        if (k == 0)
            continue;
        z -= change;
        if (!(std::abs(z - Complex(0.0, 1.0)) < farthest))
            return std::nullopt;
        if (std::abs(change) < tolerance)
            return z;
    }
    return std::nullopt;
}

} // namespace

std::optional<VibrationMode> slowest_mode(const LinearisedChain& chain) {
    const double angular_frequency = 2.0 * std::numbers::pi * lowest_natural_frequency(chain);
    if (std::isfinite(angular_frequency) && angular_frequency > 0.0)
        if (const std::optional<Complex> z = newton(chain, angular_frequency)) {
            const Complex value = angular_frequency * *z;
            const double frequency = value.imag() / (2.0 * std::numbers::pi);
            return VibrationMode{frequency, value.real(), value.real() / frequency};
        }
    const std::vector<VibrationMode> modes = vibration_modes(chain, 1);
    return modes.empty() ? std::nullopt : std::optional(modes.front());
}

} // namespace culm::integrate
