// SPDX-License-Identifier: BSD-3-Clause
// The residuals of a fitted chain over height and time, and their size by each of them.
#pragma once

#include "calibrate/chain_fit.hpp"

#include <vector>

#include <Eigen/Core>

namespace culm::diagnose {

/// Residuals over the noise, (frames, rows); 0 where nothing was seen.
[[nodiscard]] Eigen::MatrixXd whitened_residuals(const calibrate::ChainFit& fit);

/// Residuals of one height, of a part of the record, or of a range of amplitudes.
struct ResidualGroup {
    double lower = 0.0; ///< of the range: m, s, or m of the swing's amplitude
    double upper = 0.0; ///< equal to lower for a height
    std::size_t readings = 0;
    double rms = 0.0;        ///< m
    double mean = 0.0;       ///< m
    double over_noise = 0.0; ///< root mean square of residual over noise
};

[[nodiscard]] std::vector<ResidualGroup> residuals_by_height(const calibrate::ChainFit& fit);

/// Parts of equal length of the time after the release.
[[nodiscard]] std::vector<ResidualGroup> residuals_by_time(const calibrate::ChainFit& fit,
                                                           std::size_t parts);

/// `envelope`: (frames), amplitude of the swing in every frame, m; NaN for frames that do not
/// count. Groups of equal numbers of frames, the largest amplitudes first.
[[nodiscard]] std::vector<ResidualGroup> residuals_by_amplitude(const calibrate::ChainFit& fit,
                                                                const std::vector<double>& envelope,
                                                                std::size_t parts);

/// Root mean square of the noise of the rows, m.
[[nodiscard]] double typical_noise(const calibrate::ChainFit& fit);

} // namespace culm::diagnose
