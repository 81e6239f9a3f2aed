// SPDX-License-Identifier: BSD-3-Clause
// The paper's closing test: Eq. 1 read from the calibrated stem and from the measured one.
#pragma once

#include "fit/solve/fit.hpp"
#include "reduce/stem_ring_downs.hpp"

#include <optional>
#include <string>

namespace culm::calibrate {

struct CalibrationCheck {
    reduce::StemRingDowns measured;
    reduce::StemRingDowns simulated; ///< at the same times and heights, without noise
    /// Means over the heights that both fits have, weighted by the measured one's precision; the
    /// errors are simulated over measured, less 1.
    double measured_decay_per_cycle = 0.0;
    double simulated_decay_per_cycle = 0.0;
    double decay_error = 0.0;
    double measured_frequency = 0.0; ///< Hz
    double simulated_frequency = 0.0;
    double frequency_error = 0.0;
    /// One standard error of the measured values, relative: what the test can tell.
    double decay_resolution = 0.0;
    double frequency_resolution = 0.0;
};

/// Simulates the calibrated stem over the whole record and fits Eq. 1 at every height to both, in
/// the same way. Throws core::NumericalError if Eq. 1 cannot be fitted to one of them.
[[nodiscard]] CalibrationCheck check_calibration(const fit::RecordingFit& fit,
                                                 const measure::Measurement& measurement,
                                                 const reduce::RingDownAnalysisOptions& options);

} // namespace culm::calibrate
