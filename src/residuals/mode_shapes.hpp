// SPDX-License-Identifier: BSD-3-Clause
// Shapes of the first modes over the heights, measured and modelled.
#pragma once

#include "fit/solve/fit.hpp"
#include "measure/folder/measurement.hpp"

#include <vector>

namespace culm::residuals {

/// The shape of one mode over the heights: real parts of the amplitudes at the release, m, in phase
/// with the modelled mode where it is largest.
struct ModeShape {
    double frequency = 0.0;             ///< of the fitted chain, Hz
    std::vector<double> measured;       ///< (rows)
    std::vector<double> modelled;       ///< (rows)
    std::vector<double> standard_error; ///< (rows) of measured, from the noise
};

/// Every row is a sum of the fitted chain's first modes with complex amplitudes and a constant, by
/// least squares over the first five cycles, for measurement and model alike. Only modes below half
/// the frame rate are used. Empty if there are too few frames.
[[nodiscard]] std::vector<ModeShape> mode_shapes(const fit::RecordingFit& fit,
                                                 const measure::Measurement& measurement);

} // namespace culm::residuals
