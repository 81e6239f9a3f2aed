// SPDX-License-Identifier: BSD-3-Clause
// Residuals of a fit by height and time, and how far they are correlated.
#pragma once

#include "fit/fit.hpp"

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace culm::fit {

/// Residuals less the fitted error terms, over the noise and whitened, (frames, rows) or (frames,
/// series) if the noise model mixes the rows; 0 where nothing was seen.
[[nodiscard]] Eigen::MatrixXd whitened_residuals(const RecordingFit& fit);

/// Residuals of one height or of a part of the record.
struct ResidualGroup {
    double lower = 0.0; ///< of the range: m or s
    double upper = 0.0; ///< equal to lower for a height
    std::size_t readings = 0;
    double rms = 0.0;        ///< m
    double mean = 0.0;       ///< m
    double over_noise = 0.0; ///< root mean square of residual over noise
};

[[nodiscard]] std::vector<ResidualGroup> residuals_by_height(const RecordingFit& fit);

/// Parts of equal length of the time after the release.
[[nodiscard]] std::vector<ResidualGroup> residuals_by_time(const RecordingFit& fit,
                                                           std::size_t parts);

/// Root mean square of residual over noise.
[[nodiscard]] double over_noise(const RecordingFit& fit);

/// Root mean square of the noise of the rows, m.
[[nodiscard]] double typical_noise(const RecordingFit& fit);

/// Degrees of freedom of the sum of squares of a (frames, rows) table of residuals over the noise:
/// a sum of squares of Gaussian numbers with the same variance. In time n/(1 + 2 Σ r_k²) over lags
/// to `lags` (Bartlett 1946), less the sum that white noise would give; over the rows (Σ λ)²/Σ λ²
/// of the rows' covariance. At most the number of entries, at least 1.
[[nodiscard]] double effective_degrees_of_freedom(const Eigen::MatrixXd& whitened,
                                                  std::size_t lags);

} // namespace culm::fit
