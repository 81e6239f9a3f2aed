// SPDX-License-Identifier: BSD-3-Clause
// From a start to the exact minimum of the sum of squares of Eq. 1: Ceres, then Newton's method.
#pragma once

#include "reduce/ring_down_model.hpp"

#include <optional>

#include <Eigen/Core>

namespace culm::reduce {

/// A minimum of Σ (model − value)².
struct RefinedRingDown {
    RingDownParameters parameters; ///< frequency >= 0
    double residual_sum_of_squares = 0.0;
    int iterations = 0;
};

/// Levenberg-Marquardt (Ceres, dense QR, analytic Jacobian) from a start; empty if it fails. The
/// frequency of the start must not be 0: its period is the unit of time. The amplitude of the start
/// stays as it is unless amplitude_is_free.
[[nodiscard]] std::optional<RefinedRingDown> refine_ring_down(const RingDownSamples& samples,
                                                              const RingDownParameters& start,
                                                              bool amplitude_is_free);

/// Newton's method with the exact Hessian, which converges quadratically where Levenberg-Marquardt
/// slows down because of what Eq. 1 does not explain. True if the last step was below 1e-10
/// relative (of the decay: or 1e-13 per cycle).
[[nodiscard]] bool polish_ring_down(const RingDownSamples& samples, bool amplitude_is_free,
                                    RefinedRingDown& refined);

/// Covariance of (b0, b1, b2), σ² (JᵀJ)⁻¹ with σ² = RSS/(N − free parameters); rows and columns of
/// a fixed b0 are 0. Empty if the Jacobian is rank deficient.
[[nodiscard]] std::optional<Eigen::Matrix3d> ring_down_covariance(const RingDownSamples& samples,
                                                                  bool amplitude_is_free,
                                                                  const RefinedRingDown& refined);

} // namespace culm::reduce
