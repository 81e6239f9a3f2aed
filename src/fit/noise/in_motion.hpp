// SPDX-License-Identifier: BSD-3-Clause
// The noise of the readings while the stem moves, from the residuals of a fit.
#pragma once

#include "fit/solve/fit_result.hpp"

namespace culm::fit {

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
