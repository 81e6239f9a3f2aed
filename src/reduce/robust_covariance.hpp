// SPDX-License-Identifier: BSD-3-Clause
// Covariance of a least-squares fit whose residuals may be correlated.
#pragma once

#include <cstddef>
#include <span>

#include <Eigen/Core>

namespace culm::reduce {

/// Covariances of the same fit by three assumptions, each (parameters, parameters).
struct FitCovariances {
    Eigen::MatrixXd independent; ///< residuals independent, of one variance
    Eigen::MatrixXd stationary;  ///< residuals correlated the same way everywhere
    Eigen::MatrixXd newey_west;  ///< any weak correlation and any variance (Newey & West 1987)

    /// Largest variance of the linear combination `direction` of the parameters.
    [[nodiscard]] double variance(const Eigen::VectorXd& direction) const;
};

/// `jacobian` has the shape (samples, parameters), `residuals` (samples); correlation is looked for
/// up to `lags` samples, with Bartlett's weights. All are scaled by n/(n − parameters). Throws
/// core::NumericalError (FitFailed) if the Jacobian is rank deficient.
[[nodiscard]] FitCovariances fit_covariances(const Eigen::MatrixXd& jacobian,
                                             std::span<const double> residuals, std::size_t lags);

} // namespace culm::reduce
