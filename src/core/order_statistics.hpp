// SPDX-License-Identifier: BSD-3-Clause
// Medians, robust spreads and ranges of small samples.
#pragma once

#include "core/interval.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace culm::core {

/// Value at `fraction` (0 … 1) of the sorted sample, without interpolation; NaN of an empty one.
/// Reorders its argument's copy only.
template <class T>
[[nodiscard]] T quantile(std::vector<T> sample, double fraction) {
    if (sample.empty())
        return std::numeric_limits<T>::quiet_NaN();
    const auto position =
        static_cast<std::ptrdiff_t>(std::lround(fraction * static_cast<double>(sample.size() - 1)));
    std::nth_element(sample.begin(), sample.begin() + position, sample.end());
    return sample[static_cast<std::size_t>(position)];
}

template <class T>
[[nodiscard]] T median(std::vector<T> sample) {
    return quantile(std::move(sample), 0.5);
}

/// Median of the intervals between `times`; NaN of fewer than two.
[[nodiscard]] inline double median_interval(std::span<const double> times) {
    std::vector<double> intervals;
    for (std::size_t i = 1; i < times.size(); ++i)
        intervals.push_back(times[i] - times[i - 1]);
    return median(std::move(intervals));
}

/// Median absolute deviation from the median, times 1.4826: the standard deviation if the sample is
/// normal. NaN of an empty sample.
template <class T>
[[nodiscard]] T robust_deviation(const std::vector<T>& sample) {
    const T centre = median(sample);
    std::vector<T> distances;
    distances.reserve(sample.size());
    for (const T value : sample)
        distances.push_back(std::abs(value - centre));
    return T(1.4826) * median(std::move(distances));
}

/// From the smallest value to the largest; zeros of an empty sample.
[[nodiscard]] inline Interval range_of(std::span<const double> sample) {
    if (sample.empty())
        return {};
    const auto [lowest, highest] = std::ranges::minmax(sample);
    return {lowest, highest};
}

} // namespace culm::core
