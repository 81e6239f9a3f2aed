// SPDX-License-Identifier: BSD-3-Clause
// Spectrum of the residuals of a fit.
#pragma once

#include "fit/fit.hpp"

#include <vector>

namespace culm::fit {

struct ResidualSpectrum {
    std::vector<double> frequencies; ///< Hz, ascending from 0
    std::vector<double> power; ///< mean over the rows, in units of the noise's: 1 for white noise
    double resolution = 0.0;   ///< 1/duration, Hz
    std::vector<double> mode_frequencies; ///< of the fitted chain below half the frame rate, Hz
    /// (modes) share of the power above the noise's within a quarter of the mode's frequency.
    std::vector<double> mode_shares;
};

template <class To>
void describe(To& to, const ResidualSpectrum& spectrum) {
    to("frequency_hz", spectrum.frequencies);
    to("power_over_noise", spectrum.power);
    to("mode_frequencies_hz", spectrum.mode_frequencies);
    to("mode_shares", spectrum.mode_shares);
}

/// The spectrum of the frames after the release, under Hann's window, by direct summation, which
/// allows gaps and uneven times.
[[nodiscard]] ResidualSpectrum residual_spectrum(const RecordingFit& fit);

} // namespace culm::fit
