// SPDX-License-Identifier: BSD-3-Clause
// Eq. 1 of Schramm et al. (2019), y(t) = b0 exp(b1 t) cos(2π b2 t), and its derivatives.
#pragma once

#include <numbers>
#include <vector>

#include <Eigen/Core>

namespace culm::reduce {

inline constexpr double two_pi = 2.0 * std::numbers::pi;

/// A normalised history; both of the same length. The unit of time is the reader's choice.
struct RingDownSamples {
    std::vector<double> times;
    std::vector<double> values;
};

/// b0, b1 (1/time), b2 (1/time).
struct RingDownParameters {
    double amplitude = 0.0;
    double decay_rate = 0.0;
    double frequency = 0.0;
};

/// Value of Eq. 1 at one time with its gradient by (b0, b1, b2).
struct RingDownPoint {
    double value = 0.0;
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
};

[[nodiscard]] RingDownPoint evaluate_ring_down(const RingDownParameters& parameters, double time);

/// Second derivatives of Eq. 1 by (b0, b1, b2), shape (3, 3), from the gradient at the same point.
[[nodiscard]] Eigen::Matrix3d ring_down_hessian(const RingDownParameters& parameters, double time,
                                                const Eigen::Vector3d& gradient);

} // namespace culm::reduce
