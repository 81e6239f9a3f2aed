// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/ring_down_start.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <cstddef>
#include <functional>

#include <unsupported/Eigen/FFT>

namespace culm::reduce {

namespace {

constexpr std::size_t most_starts = 4;
constexpr std::size_t most_bins = 32768; // bounds the cost for very irregular times
constexpr double worthwhile_share = 0.5; // a true peak loses at most a third between grid points

/// The history in equal bins, starting at t = 0.
struct BinnedHistory {
    double width = 0.0;
    std::vector<double> sum;   // of the values in the bin
    std::vector<double> count; // of samples in the bin
};

BinnedHistory bin_history(const RingDownSamples& samples) {
    const double last = samples.times.back();
    BinnedHistory binned;
    binned.width = std::max(median_interval(samples.times), last / static_cast<double>(most_bins));
    const auto bins = static_cast<std::size_t>(std::lround(last / binned.width)) + 1;
    binned.sum.assign(bins, 0.0);
    binned.count.assign(bins, 0.0);
    for (std::size_t i = 0; i < samples.times.size(); ++i) {
        const auto bin = static_cast<std::size_t>(std::lround(samples.times[i] / binned.width));
        binned.sum[bin] += samples.values[i];
        binned.count[bin] += 1.0;
    }
    return binned;
}

/// A local maximum of the scan.
struct Peak {
    RingDownParameters parameters;
    double explained = 0.0;  // sum of squares
    double separation = 0.0; // peaks nearer than this in frequency are the same one
};

/// Spectrum of two real sequences packed as the real and imaginary part of one.
std::vector<std::complex<double>> packed_spectrum(const BinnedHistory& history, double rate,
                                                  std::size_t length) {
    std::vector<std::complex<double>> packed(std::bit_ceil(std::max<std::size_t>(4 * length, 64)));
    for (std::size_t k = 0; k < length; ++k) {
        const double envelope = std::exp(-rate * static_cast<double>(k) * history.width);
        packed[k] = {history.sum[k] * envelope, history.count[k] * envelope * envelope};
    }
    std::vector<std::complex<double>> spectrum;
    Eigen::FFT<double> transform;
    transform.fwd(spectrum, packed);
    return spectrum;
}

/// Adds the local maxima over frequency for one decay rate (1/time, >= 0).
void scan_decay(const BinnedHistory& history, double rate, double largest_decay_per_cycle,
                std::vector<Peak>& peaks) {
    // Beyond six decay times the envelope has nothing left to correlate.
    const double reach = rate > 0.0 ? 6.0 / (rate * history.width) : 1e9;
    const std::size_t length =
        std::min(history.sum.size(), static_cast<std::size_t>(std::ceil(reach)) + 2);
    const std::vector<std::complex<double>> spectrum = packed_spectrum(history, rate, length);
    const std::size_t size = spectrum.size();

    std::vector<double> amplitude(size / 2 + 1, 0.0);
    std::vector<double> explained(size / 2 + 1, 0.0);
    const double weight = spectrum[0].imag();
    for (std::size_t k = 1; k <= size / 2; ++k) {
        const double correlation = 0.5 * (spectrum[k].real() + spectrum[size - k].real());
        const std::size_t twice = (2 * k) % size;
        const std::size_t mirror = (size - twice) % size;
        const double cosine = 0.5 * (spectrum[twice].imag() + spectrum[mirror].imag());
        const double norm = 0.5 * (weight + cosine);
        if (norm <= 1e-9 * weight)
            continue;
        amplitude[k] = correlation / norm;
        explained[k] = correlation * amplitude[k];
    }

    const double step = 1.0 / (static_cast<double>(size) * history.width);
    for (std::size_t k = 1; k <= size / 2; ++k) {
        const bool above_left = k == 1 || explained[k] >= explained[k - 1];
        const bool above_right = k == size / 2 || explained[k] > explained[k + 1];
        const double frequency = static_cast<double>(k) * step;
        if (above_left && above_right && explained[k] > 0.0 &&
            rate <= largest_decay_per_cycle * frequency)
            peaks.push_back({{amplitude[k], -rate, frequency},
                             explained[k],
                             0.5 / (static_cast<double>(length) * history.width)});
    }
}

} // namespace

double median_interval(const std::vector<double>& times) {
    std::vector<double> intervals(times.size() - 1);
    for (std::size_t i = 0; i + 1 < times.size(); ++i)
        intervals[i] = times[i + 1] - times[i];
    const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
    std::nth_element(intervals.begin(), middle, intervals.end());
    return *middle;
}

std::vector<RingDownParameters> ring_down_starts(const RingDownSamples& samples,
                                                 double largest_decay_per_cycle) {
    const BinnedHistory history = bin_history(samples);
    std::vector<Peak> peaks;
    scan_decay(history, 0.0, largest_decay_per_cycle, peaks);
    const double duration = samples.times.back();
    for (double rate = 1.0 / duration; rate * history.width < 2.0; rate *= 2.0)
        scan_decay(history, rate, largest_decay_per_cycle, peaks);

    std::ranges::sort(peaks, std::ranges::greater{}, &Peak::explained);
    std::vector<Peak> kept;
    for (const Peak& peak : peaks) {
        if (kept.size() == most_starts ||
            peak.explained < worthwhile_share * peaks.front().explained)
            break;
        const bool is_new = std::ranges::none_of(kept, [&](const Peak& other) {
            return std::abs(peak.parameters.frequency - other.parameters.frequency) <
                   std::max(peak.separation, other.separation);
        });
        if (is_new)
            kept.push_back(peak);
    }
    std::vector<RingDownParameters> starts(kept.size());
    std::ranges::transform(kept, starts.begin(), &Peak::parameters);
    return starts;
}

} // namespace culm::reduce
