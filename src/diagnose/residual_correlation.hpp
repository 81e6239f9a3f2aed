// SPDX-License-Identifier: BSD-3-Clause
// How many independent readings there are in residuals that are correlated in time and over the
// rows, and whether the rows share a pattern.
#pragma once

#include <cstddef>
#include <span>

#include <Eigen/Core>

namespace culm::diagnose {

/// Degrees of freedom of the sum of squares of a (frames, rows) table of residuals over the noise:
/// a sum of squares of Gaussian numbers with the same variance. In time n/(1 + 2 Σ r_k²) over lags
/// to `lags` (Bartlett 1946), with what white noise would give for the sum taken off; over the rows
/// (Σ λ)²/Σ λ² of the rows' covariance. At most the number of entries, at least 1.
[[nodiscard]] double effective_degrees_of_freedom(const Eigen::MatrixXd& whitened,
                                                  std::size_t lags);

/// Sum over the rows of n (1 − ρ)/(1 + ρ), with ρ the correlation of neighbouring frames, from 0 to
/// 0.99: independent readings as far as a mean is concerned. For information criteria.
[[nodiscard]] double effective_readings(const Eigen::MatrixXd& whitened);

struct SpatialPattern {
    double p_value = 1.0;  ///< of a first singular value at least as large, if all is white noise
    double share = 0.0;    ///< of the first singular value's square in the sum of all
    Eigen::VectorXd shape; ///< (rows), of length 1: the pattern over the heights, over the noise
};

/// The first singular value of the table against that of white noise of the same overall size:
/// Johnstone's (2001) centring and scaling, and the Tracy-Widom law of order 1 as a shifted gamma
/// distribution (Chiani 2014), good to 1e-3. Needs two rows or more.
[[nodiscard]] SpatialPattern spatial_pattern(const Eigen::MatrixXd& whitened);

/// P(χ² ≥ value) for any positive number of degrees of freedom.
[[nodiscard]] double chi_squared_tail(double value, double degrees_of_freedom);

} // namespace culm::diagnose
