// SPDX-License-Identifier: BSD-3-Clause
// The numbers of a model whose residuals are not noise: each row of a recording is taken as
// correlated noise, e_i = ρ e_{i−1} + white noise.
#pragma once

#include "diagnose/score/stacked_readings.hpp"
#include "fit/fit_model.hpp"

#include <cstddef>
#include <optional>
#include <span>
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

/// Where a model misses its readings, the misses of neighbouring frames are alike. Least squares
/// counts each for itself: a creeping zero then pulls at every number as hard as the swing does,
/// and the intervals are far too narrow.
struct CorrelatedEstimate {
    std::vector<fit::FittedParameter> parameters; ///< as the fit's, with new values
    std::vector<std::vector<double>> correlation; ///< (recordings)(rows) of neighbouring frames
};

/// The fit's numbers by generalised least squares (Cochrane & Orcutt 1949, from readings after the
/// release): the misses of a row are correlated noise of the first order whose correlation and size
/// are estimated with them; standard errors by frames (covariance_by_frames). Nothing if the chain
/// fails on the way, or if no row's misses are correlated: then the fit says it all.
[[nodiscard]] std::optional<CorrelatedEstimate>
correlated_estimate(const fit::Fit& fit, std::span<const measure::Measurement> recordings,
                    const fit::FitOptions& options = {});

} // namespace culm::diagnose
