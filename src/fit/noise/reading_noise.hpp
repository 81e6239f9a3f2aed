// SPDX-License-Identifier: BSD-3-Clause
// Noise of the readings of a measurement: stated, or estimated at rest or, from the residuals of a
// fit, in motion.
#pragma once

#include "fit/solve/fit_result.hpp"

#include <string>
#include <vector>

namespace culm::fit {

struct ReadingNoise {
    std::vector<double> by_row; ///< (rows), m; empty: only the residuals of a fit determine it
    std::string source;         ///< "stated", or the data of the estimate
    bool is_known = true;       ///< independent of the fit
};

/// The noise of the noise model if there is one. Otherwise the first of these that is available:
/// the stated noise of each reading (the mean square of a row) or of each row; the scatter about
/// each row's mean while the stem was held, over at least 20 degrees of freedom of all rows
/// together; the scatter of the second differences over the last tenth of the record if the motion
/// there is below the noise; none.
[[nodiscard]] ReadingNoise reading_noise(const ObservedRecording& measurement);

/// Noise of each reading over that of its row, (times, rows); empty: 1.
[[nodiscard]] std::vector<double> relative_noise(const measure::Measurement& measurement,
                                                 const std::vector<double>& by_row);

/// The recording with the noise of its readings while the stem moves. The noise is estimated from
/// the residuals without the parts at the modes and in a drift, at the Fourier frequencies that
/// these do not affect: Student's t of outliers, which are then down-weighted (Lange et al. 1989),
/// the correlation in time by Whittle's likelihood, and that of the rows. Each is used if noise
/// without it shows as much in one recording of a thousand. A recording with less than 64 frames or
/// 20 such frequencies is returned unchanged.
[[nodiscard]] ObservedRecording with_noise_in_motion(const RecordingFit& fit,
                                                     const ObservedRecording& measurement);

/// Do two estimates for one recording agree on its noise in motion, with its size to 1 %?
[[nodiscard]] bool has_same_noise(const ObservedRecording& one, const ObservedRecording& other);

} // namespace culm::fit
