// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/histogram.hpp"

#include <algorithm>
#include <cmath>

namespace culm::reduce {

namespace {

constexpr double most_bins = 100.0;

/// Linear interpolation between order statistics.
double quantile(const std::vector<double>& sorted, double fraction) {
    const double place = fraction * static_cast<double>(sorted.size() - 1);
    const auto below = static_cast<std::size_t>(place);
    const std::size_t above = std::min(below + 1, sorted.size() - 1);
    return std::lerp(sorted[below], sorted[above], place - static_cast<double>(below));
}

/// The smallest of 1, 2, 5 times a power of ten that is not below `width`.
double round_up(double width) {
    const double decade = std::pow(10.0, std::floor(std::log10(width)));
    for (const double step : {1.0, 2.0, 5.0})
        if (step * decade >= width * (1.0 - 1e-12))
            return step * decade;
    return 10.0 * decade;
}

double suitable_width(const std::vector<double>& sorted) {
    const auto n = static_cast<double>(sorted.size());
    const double range = sorted.back() - sorted.front();
    double width = 2.0 * (quantile(sorted, 0.75) - quantile(sorted, 0.25)) / std::cbrt(n);
    if (width <= 0.0)
        width = range / (1.0 + std::log2(n));
    return round_up(std::max(width, range / (most_bins - 2.0)));
}

} // namespace

Histogram make_histogram(std::span<const double> values) {
    if (values.empty())
        return {};
    std::vector<double> sorted(values.begin(), values.end());
    std::ranges::sort(sorted);
    const double largest = std::max(std::abs(sorted.front()), std::abs(sorted.back()));
    // A spread at rounding level is no spread.
    if (sorted.back() - sorted.front() <= 1e-12 * largest || largest == 0.0) {
        const double width = largest > 0.0 ? round_up(largest) : 1.0;
        const double middle = 0.5 * (sorted.front() + sorted.back());
        return {{middle - 0.5 * width, middle + 0.5 * width}, {sorted.size()}};
    }
    const double width = suitable_width(sorted);
    const double first = std::floor(sorted.front() / width);
    const double last = std::floor(sorted.back() / width) + 1.0;
    const auto bins = static_cast<std::size_t>(last - first);
    Histogram histogram;
    histogram.counts.assign(bins, 0);
    for (std::size_t k = 0; k <= bins; ++k)
        histogram.edges.push_back((first + static_cast<double>(k)) * width);
    for (const double value : sorted) {
        const auto bin = static_cast<std::size_t>(std::floor(value / width) - first);
        ++histogram.counts[std::min(bin, bins - 1)];
    }
    return histogram;
}

} // namespace culm::reduce
