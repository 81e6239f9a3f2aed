// SPDX-License-Identifier: BSD-3-Clause
// Starts for the fit of Eq. 1: the best peaks of a scan over frequency and decay.
#include "core/order_statistics.hpp"
#include "reduce/ring_down/ring_down_model.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <cstddef>
#include <utility>

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
    binned.width =
        std::max(core::median_interval(samples.times), last / static_cast<double>(most_bins));
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

/// Two real sequences, or their spectra, packed as the real and imaginary part of one.
using Packed = std::vector<std::complex<double>>;

/// Sums of squares explained by the trials at the frequencies k = 0 … half the size of a spectrum.
class Explained {
  public:
    /// The size of the spectrum is a power of two.
    void evaluate(const Packed& spectrum) {
        const std::size_t size = spectrum.size();
        const std::size_t half = size / 2;
        for (std::vector<double>* list : {&correlation_, &cosine_, &norm_, &sum_of_squares_})
            list->resize(half + 1);
        correlation_[0] = spectrum[0].real();
        cosine_[0] = spectrum[0].imag();
        for (std::size_t k = 1; k <= half; ++k) {
            correlation_[k] = 0.5 * (spectrum[k].real() + spectrum[size - k].real());
            cosine_[k] = 0.5 * (spectrum[k].imag() + spectrum[size - k].imag());
        }
        // Σ (e cos)² = (Σ e² + Σ e² cos 2x)/2; spectra of real sequences repeat mirrored.
        const double weight = cosine_[0];
        for (std::size_t k = 0; k <= half / 2; ++k)
            norm_[k] = 0.5 * (weight + cosine_[2 * k]);
        for (std::size_t k = half / 2 + 1; k <= half; ++k)
            norm_[k] = 0.5 * (weight + cosine_[size - 2 * k]);
        const double negligible = 1e-9 * weight;
        for (std::size_t k = 0; k <= half; ++k)
            sum_of_squares_[k] =
                norm_[k] > negligible ? correlation_[k] * (correlation_[k] / norm_[k]) : 0.0;
        sum_of_squares_[0] = 0.0; // no vibration
    }

    [[nodiscard]] double sum_of_squares(std::size_t k) const { return sum_of_squares_[k]; }
    /// Valid where the sum of squares is positive.
    [[nodiscard]] double amplitude(std::size_t k) const { return correlation_[k] / norm_[k]; }

  private:
    std::vector<double> correlation_;
    std::vector<double> cosine_;
    std::vector<double> norm_;
    std::vector<double> sum_of_squares_;
};

/// The scan over decay rates, with the data that its transforms share.
class Scan {
  public:
    Scan(const BinnedHistory& history, double largest_decay_per_cycle)
        : history_(history), largest_decay_per_cycle_(largest_decay_per_cycle) {}

    /// Adds the local maxima over frequency for one decay rate (1/time, >= 0) that are worthwhile
    /// compared with the best so far.
    void add_decay(double rate) {
        // Beyond six decay times the envelope is negligible.
        const double reach = rate > 0.0 ? 6.0 / (rate * history_.width) : 1e9;
        const std::size_t length =
            std::min(history_.sum.size(), static_cast<std::size_t>(std::ceil(reach)) + 2);
        transform(rate, length);
        explained_.evaluate(spectrum_);
        const double separation = 0.5 / (static_cast<double>(length) * history_.width);
        const double step = 1.0 / (static_cast<double>(spectrum_.size()) * history_.width);
        const std::size_t last = spectrum_.size() / 2;
        for (std::size_t k = 1; k <= last; ++k) {
            const double explained = explained_.sum_of_squares(k);
            if (!(explained > 0.0 && explained >= worthwhile_share * best_))
                continue;
            const bool above_left = k == 1 || explained >= explained_.sum_of_squares(k - 1);
            const bool above_right = k == last || explained > explained_.sum_of_squares(k + 1);
            const double frequency = static_cast<double>(k) * step;
            if (!above_left || !above_right || rate > largest_decay_per_cycle_ * frequency)
                continue;
            peaks_.push_back({{explained_.amplitude(k), -rate, frequency}, explained, separation});
            best_ = std::max(best_, explained);
        }
    }

    /// Best first.
    [[nodiscard]] std::vector<Peak> take_peaks() {
        std::ranges::sort(peaks_, std::ranges::greater{}, &Peak::explained);
        return std::move(peaks_);
    }

  private:
    /// Transforms history times envelope e^(-rate t), and the squared envelope at the samples.
    void transform(double rate, std::size_t length) {
        packed_.assign(std::bit_ceil(std::max<std::size_t>(4 * length, 64)), {});
        for (std::size_t k = 0; k < length; ++k) {
            const double envelope = std::exp(-rate * static_cast<double>(k) * history_.width);
            packed_[k] = {history_.sum[k] * envelope, history_.count[k] * envelope * envelope};
        }
        transform_.fwd(spectrum_, packed_);
    }

    const BinnedHistory& history_;
    double largest_decay_per_cycle_;
    Packed packed_;
    Packed spectrum_;
    Eigen::FFT<double> transform_; // transforms of one length share its tables
    Explained explained_;
    std::vector<Peak> peaks_;
    double best_ = 0.0;
};

} // namespace

std::vector<RingDownParameters> ring_down_starts(const RingDownSamples& samples,
                                                 double largest_decay_per_cycle) {
    const BinnedHistory history = bin_history(samples);
    Scan scan(history, largest_decay_per_cycle);
    scan.add_decay(0.0);
    const double duration = samples.times.back();
    for (double rate = 1.0 / duration; rate * history.width < 2.0; rate *= 2.0)
        scan.add_decay(rate);

    const std::vector<Peak> peaks = scan.take_peaks();
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
