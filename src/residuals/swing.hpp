// SPDX-License-Identifier: BSD-3-Clause
// The strongest shape of the motion over the heights, and its coordinate in measurement and model.
#pragma once

#include "fit/solve/fit.hpp"
#include "measure/folder/measurement.hpp"

#include <vector>

namespace culm::residuals {

/// The heights move together in the shape that holds most of the motion (the first mode where one
/// mode dominates; of two close modes their common shape). Coordinates are those of the row where
/// the shape is largest, m.
struct Swing {
    std::vector<double> shape;          ///< (rows), 1 at the largest
    std::vector<double> times;          ///< (frames), s
    std::vector<double> measured;       ///< (frames), m; NaN where no row was seen
    std::vector<double> modelled;       ///< (frames), m, from the rows that were seen
    std::vector<double> modelled_speed; ///< (frames), m/s
    double noise = 0.0;                 ///< of a measured coordinate with all rows, m
    double frequency = 0.0;             ///< of the fitted chain's first mode, Hz
};

/// The shape is the first right singular vector of the predicted readings after the release (of the
/// measured ones, if the model does not move), weighted by the noise.
[[nodiscard]] Swing swing_of(const fit::RecordingFit& fit, const measure::Measurement& measurement);

} // namespace culm::residuals
