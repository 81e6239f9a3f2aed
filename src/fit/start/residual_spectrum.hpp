// SPDX-License-Identifier: BSD-3-Clause
// Spectrum of the residuals of a fit.
#pragma once

#include "fit/fit.hpp"

#include <string>
#include <vector>

namespace culm::fit {

struct SpectrumBand {
    std::string name;   ///< "mode 1", "twice mode 1", "below half of mode 1", …
    double lower = 0.0; ///< Hz
    double upper = 0.0;
    double share = 0.0; ///< of the power of all bands together, less the noise's; 0 … 1
};

template <class To>
void describe(To& to, const SpectrumBand& band) {
    to("name", band.name);
    to("lower_hz", band.lower);
    to("upper_hz", band.upper);
    to("share", band.share);
}

struct ResidualSpectrum {
    std::vector<double> frequencies; ///< Hz, ascending from 0
    std::vector<double> power; ///< mean over the rows, in units of the noise's: 1 for white noise
    double resolution = 0.0;   ///< 1/duration, Hz
    std::vector<double> mode_frequencies; ///< of the fitted chain below half the frame rate, Hz
    std::vector<SpectrumBand> bands;      ///< about the modes and multiples of the first one
};

template <class To>
void describe(To& to, const ResidualSpectrum& spectrum) {
    to("frequency_hz", spectrum.frequencies);
    to("power_over_noise", spectrum.power);
    to("mode_frequencies_hz", spectrum.mode_frequencies);
    to("bands", spectrum.bands);
}

/// The spectrum of the frames after the release, under Hann's window, by direct summation, which
/// allows gaps and uneven times. Bands reach a quarter of a frequency to either side.
[[nodiscard]] ResidualSpectrum residual_spectrum(const RecordingFit& fit);

} // namespace culm::fit
