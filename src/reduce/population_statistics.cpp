// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/population_statistics.hpp"

#include "reduce/distributions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <boost/math/distributions/chi_squared.hpp>

namespace culm::reduce {

namespace {

constexpr double most_bins = 100.0;

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
    // Freedman & Diaconis (1981): 2 IQR n^(−1/3), which is 0 if half of the values are equal.
    // Sturges's number of bins, 1 + log2 n, needs only the range.
    double width = 2.0 * (quantile(sorted, 0.75) - quantile(sorted, 0.25)) / std::cbrt(n);
    if (width <= 0.0)
        width = range / (1.0 + std::log2(n));
    return round_up(std::max(width, range / (most_bins - 2.0)));
}

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// (n − 1)s²/σ² is χ² of n − 1 degrees of freedom for a normal sample.
Bounds deviation_interval(double deviation, std::size_t freedom) {
    const boost::math::chi_squared distribution(static_cast<double>(freedom));
    const double tail = 0.5 * (1.0 - confidence_level);
    const double sum = deviation * deviation * static_cast<double>(freedom);
    return {std::sqrt(sum / boost::math::quantile(boost::math::complement(distribution, tail))),
            std::sqrt(sum / boost::math::quantile(distribution, tail))};
}

} // namespace

Histogram make_histogram(std::span<const double> values) {
    if (values.empty())
        return {};
    std::vector<double> sorted(values.begin(), values.end());
    std::ranges::sort(sorted);
    const double largest = std::max(std::abs(sorted.front()), std::abs(sorted.back()));
    // A spread at rounding level counts as zero.
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

double quantile(std::span<const double> ascending, double share) {
    // Linear between order statistics (type 7 of Hyndman & Fan 1996, the default of NumPy and R).
    const double place = share * static_cast<double>(ascending.size() - 1);
    const auto below = static_cast<std::size_t>(place);
    const std::size_t above = std::min(below + 1, ascending.size() - 1);
    return std::lerp(ascending[below], ascending[above], place - static_cast<double>(below));
}

SampleSummary summarise(std::span<const double> values) {
    SampleSummary summary;
    summary.count = values.size();
    summary.mean_interval = summary.standard_deviation_interval = {unknown, unknown};
    summary.standard_deviation = unknown;
    if (values.empty()) {
        summary.mean = summary.lowest = summary.highest = summary.median = unknown;
        summary.central_90_percent = {unknown, unknown};
        return summary;
    }
    std::vector<double> sorted(values.begin(), values.end());
    std::ranges::sort(sorted);
    const auto n = static_cast<double>(sorted.size());
    summary.mean = std::accumulate(sorted.begin(), sorted.end(), 0.0) / n;
    summary.lowest = sorted.front();
    summary.highest = sorted.back();
    summary.median = quantile(sorted, 0.5);
    summary.central_90_percent = {quantile(sorted, 0.05), quantile(sorted, 0.95)};
    summary.histogram = make_histogram(values);
    if (sorted.size() < 2)
        return summary;
    double sum = 0.0;
    for (const double value : sorted)
        sum += (value - summary.mean) * (value - summary.mean);
    const std::size_t freedom = sorted.size() - 1;
    summary.standard_deviation = std::sqrt(sum / static_cast<double>(freedom));
    const double half = student_t_factor(freedom) * summary.standard_deviation / std::sqrt(n);
    summary.mean_interval = {summary.mean - half, summary.mean + half};
    summary.standard_deviation_interval = deviation_interval(summary.standard_deviation, freedom);
    return summary;
}

LineFit fit_line(std::span<const double> x, std::span<const double> y,
                 std::span<const double> weights) {
    LineFit line;
    const std::size_t n = x.size();
    const auto weight = [&](std::size_t i) { return weights.empty() ? 1.0 : weights[i]; };
    // The sums are taken about the means: Σ x² − n x̄² would lose the digits that x and x̄ share.
    double sum = 0.0;
    double mean_x = 0.0;
    double mean_y = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
        sum += weight(i);
        mean_x += weight(i) * x[i];
        mean_y += weight(i) * y[i];
    }
    mean_x /= sum;
    mean_y /= sum;
    double xx = 0.0;
    double xy = 0.0;
    double yy = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
        xx += weight(i) * (x[i] - mean_x) * (x[i] - mean_x);
        xy += weight(i) * (x[i] - mean_x) * (y[i] - mean_y);
        yy += weight(i) * (y[i] - mean_y) * (y[i] - mean_y);
    }
    // Abscissas that differ by rounding alone determine no slope.
    if (n < 3 || !(xx > 1e-24 * sum * mean_x * mean_x) || !(xx > 0.0))
        return line;
    line.count = n;
    line.slope = xy / xx;
    line.intercept = mean_y - line.slope * mean_x;
    const double rest = std::max(0.0, yy - line.slope * xy);
    // s² = Σ w (y − fitted)²/(n − 2), and the slope's variance is s²/Σ w (x − x̄)².
    line.slope_error = std::sqrt(rest / static_cast<double>(n - 2) / xx);
    const double half = student_t_factor(n - 2) * line.slope_error;
    line.slope_interval = {line.slope - half, line.slope + half};
    line.correlation = yy > 0.0 ? xy / std::sqrt(xx * yy) : 0.0;
    if (line.slope != 0.0)
        line.p_value = student_t_p_value(line.slope / line.slope_error, n - 2);
    return line;
}

std::vector<double> holm_adjusted(std::span<const double> p_values) {
    std::vector<std::size_t> order(p_values.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::sort(order, {}, [&](std::size_t i) { return p_values[i]; });
    std::vector<double> adjusted(p_values.size());
    // Holm (1979): the k-th smallest of m p-values times m − k + 1; the results must ascend.
    double largest = 0.0;
    for (std::size_t rank = 0; rank < order.size(); ++rank) {
        const auto left = static_cast<double>(order.size() - rank);
        largest = std::max(largest, std::min(1.0, left * p_values[order[rank]]));
        adjusted[order[rank]] = largest;
    }
    return adjusted;
}

} // namespace culm::reduce
