// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/ring_down_basis.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace culm::reduce {

namespace {

constexpr Eigen::Index block = 64; // samples that share one pair of exponential and sine

/// The interval of equally spaced times, 0 if they are not: a deviation counts when it is more than
/// the rounding of the times themselves.
double equal_interval(const Eigen::ArrayXd& times) {
    const Eigen::Index samples = times.size();
    if (samples < 2 * block)
        return 0.0;
    const double interval = (times[samples - 1] - times[0]) / static_cast<double>(samples - 1);
    const double largest = std::max(std::abs(times[0]), std::abs(times[samples - 1]));
    const double rounding = 4.0 * std::numeric_limits<double>::epsilon() * largest;
    for (Eigen::Index i = 0; i < samples; ++i)
        if (std::abs(times[0] + static_cast<double>(i) * interval - times[i]) > rounding)
            return 0.0;
    return interval;
}

} // namespace

RingDownBasis::RingDownBasis(std::span<const double> times)
    : times_(
          Eigen::Map<const Eigen::ArrayXd>(times.data(), static_cast<Eigen::Index>(times.size()))),
      interval_(equal_interval(times_)), in_phase_(times_.size()), quadrature_(times_.size()) {}

void RingDownBasis::evaluate(double decay_rate, double frequency) {
    const double angular_frequency = 2.0 * std::numbers::pi * frequency;
    if (interval_ > 0.0) {
        evaluate_blockwise(decay_rate, angular_frequency);
        return;
    }
    for (Eigen::Index i = 0; i < times_.size(); ++i) {
        const double envelope = std::exp(decay_rate * times_[i]);
        const double phase = angular_frequency * times_[i];
        in_phase_[i] = envelope * std::cos(phase);
        quadrature_[i] = envelope * std::sin(phase);
    }
}

void RingDownBasis::evaluate_blockwise(double decay_rate, double angular_frequency) {
    const Eigen::Index samples = times_.size();
    // Within the first block, relative to its first sample.
    Eigen::Array<double, block, 1> cosine;
    Eigen::Array<double, block, 1> sine;
    for (Eigen::Index j = 0; j < block; ++j) {
        const double time = static_cast<double>(j) * interval_;
        const double envelope = std::exp(decay_rate * time);
        cosine[j] = envelope * std::cos(angular_frequency * time);
        sine[j] = envelope * std::sin(angular_frequency * time);
    }
    for (Eigen::Index first = 0; first < samples; first += block) {
        const Eigen::Index count = std::min(block, samples - first);
        const double envelope = std::exp(decay_rate * times_[first]);
        const double c = envelope * std::cos(angular_frequency * times_[first]);
        const double s = envelope * std::sin(angular_frequency * times_[first]);
        in_phase_.segment(first, count) = c * cosine.head(count) - s * sine.head(count);
        quadrature_.segment(first, count) = s * cosine.head(count) + c * sine.head(count);
    }
}

} // namespace culm::reduce
