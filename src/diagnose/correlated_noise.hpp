// SPDX-License-Identifier: BSD-3-Clause
// Residuals as noise that remembers: each row of a recording follows e_i = ρ e_{i−1} + white noise.
#pragma once

#include "diagnose/stacked_readings.hpp"

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace culm::diagnose {

/// One row of one recording, frame after frame.
struct ReadingSequence {
    std::vector<Eigen::Index> readings; ///< rows of the stacked readings; -1 where nothing was seen
    std::size_t first_frame = 0;        ///< number of its first frame, counted over all recordings
};

/// Of every sequence.
struct CorrelatedNoise {
    std::vector<double> correlation; ///< of neighbouring frames, 0 to 0.99; 0 if it may be chance
    std::vector<double> deviation;   ///< of the white part, in the unit of the residuals
    double cost = 0.0;               ///< Σ n ln deviation: minus the logarithm of the likelihood
};

[[nodiscard]] CorrelatedNoise correlated_noise(const Eigen::VectorXd& residual,
                                               const std::vector<ReadingSequence>& sequences);

/// The white parts of residuals and derivatives over their deviation, and the frame of each.
struct WhitenedReadings {
    StackedReadings stacked;
    std::vector<std::size_t> frames;
};
[[nodiscard]] WhitenedReadings whitened(const StackedReadings& stacked,
                                        const std::vector<ReadingSequence>& sequences,
                                        const CorrelatedNoise& noise);

/// Covariance of a least squares solution whose residuals may differ in size from frame to frame
/// and be correlated within one (the sandwich of White 1980, over frames; the rows of a frame miss
/// together). Rows and columns of columns that are held, or tell nothing, are 0.
[[nodiscard]] Eigen::MatrixXd covariance_by_frames(const WhitenedReadings& readings,
                                                   const std::vector<bool>& is_held);

} // namespace culm::diagnose
