// SPDX-License-Identifier: BSD-3-Clause
#include "fit/start/residual_spectrum.hpp"

#include "run/modes.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace culm::fit {

namespace {

constexpr std::size_t most_frequencies = 2000;
constexpr std::size_t mode_count = 3;

/// Hann's window for the frames from `first` on. The residual of a decaying swing ends abruptly at
/// both ends of the record; without a window its side lobes (−13 dB) would look like vibrations.
/// Those of Hann's window fall by 18 dB an octave.
std::vector<double> window_from(std::size_t first, const std::vector<double>& times) {
    std::vector<double> weights;
    for (std::size_t i = first; i < times.size(); ++i)
        weights.push_back(std::pow(std::sin(std::numbers::pi * times[i] / times.back()), 2));
    return weights;
}

/// A periodogram at any frequency, also for frames with gaps; white noise of size σ has the mean 1:
/// |Σ w r e^(−iωt)|² / (σ² Σ w²), averaged over the rows. `weights`: of the last frames.
double power_at(const RecordingFit& fit, const std::vector<double>& weights, double frequency) {
    const std::size_t rows = fit.prediction.rows;
    std::vector<std::complex<double>> sums(rows);
    std::vector<double> norms(rows, 0.0);
    for (std::size_t k = 0; k < weights.size(); ++k) {
        const std::size_t i = fit.times.size() - weights.size() + k;
        const double weight = weights[k];
        const std::complex<double> turn =
            std::polar(weight, -2.0 * std::numbers::pi * frequency * fit.times[i]);
        for (std::size_t j = 0; j < rows; ++j) {
            const double residual = fit.residuals[i * rows + j];
            if (std::isnan(residual))
                continue;
            sums[j] += turn * (residual / fit.noise[j]);
            norms[j] += weight * weight;
        }
    }
    double power = 0.0;
    std::size_t seen = 0;
    for (std::size_t j = 0; j < rows; ++j)
        if (norms[j] > 0.0) {
            power += std::norm(sums[j]) / norms[j];
            ++seen;
        }
    return seen == 0 ? 0.0 : power / static_cast<double>(seen);
}

/// Power above that of the noise between two frequencies.
double excess_between(const ResidualSpectrum& spectrum, double lower, double upper) {
    double sum = 0.0;
    for (std::size_t k = 0; k < spectrum.frequencies.size(); ++k)
        if (spectrum.frequencies[k] >= lower && spectrum.frequencies[k] < upper)
            sum += std::max(spectrum.power[k] - 1.0, 0.0);
    return sum;
}

} // namespace

ResidualSpectrum residual_spectrum(const RecordingFit& fit) {
    ResidualSpectrum spectrum;
    const auto released = std::ranges::lower_bound(fit.times, 0.0);
    const std::vector<double> weights =
        window_from(static_cast<std::size_t>(released - fit.times.begin()), fit.times);
    if (weights.size() < 4)
        return spectrum;
    const double duration = fit.times.back();
    spectrum.resolution = 1.0 / duration;
    const double half_rate = 0.5 * static_cast<double>(weights.size() - 1) / (duration - *released);
    const auto count =
        std::min(static_cast<std::size_t>(half_rate * duration) + 1, most_frequencies);
    for (std::size_t k = 0; k < count; ++k) {
        spectrum.frequencies.push_back(static_cast<double>(k) * spectrum.resolution);
        // A real constant has all its power at one frequency, a vibration half of it at −f.
        spectrum.power.push_back(power_at(fit, weights, spectrum.frequencies.back()));
    }
    for (const integrate::VibrationMode& mode : run::chain_modes(fit.model.spec, mode_count))
        if (mode.frequency < half_rate)
            spectrum.mode_frequencies.push_back(mode.frequency);
    const double all = excess_between(spectrum, 0.0, half_rate);
    for (const double mode : spectrum.mode_frequencies)
        spectrum.mode_shares.push_back(
            all > 0.0 ? excess_between(spectrum, 0.75 * mode, 1.25 * mode) / all : 0.0);
    return spectrum;
}

} // namespace culm::fit
