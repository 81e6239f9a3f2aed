// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/population_statistics.hpp"

#include "reduce/distributions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>

namespace culm::reduce {

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr double tail = 0.5 * (1.0 - confidence_level);

/// (n − 1)s²/σ² is χ² of n − 1 degrees of freedom for a normal sample.
Bounds deviation_interval(double deviation, std::size_t freedom) {
    const boost::math::chi_squared distribution(static_cast<double>(freedom));
    const double sum = deviation * deviation * static_cast<double>(freedom);
    return {std::sqrt(sum / boost::math::quantile(boost::math::complement(distribution, tail))),
            std::sqrt(sum / boost::math::quantile(distribution, tail))};
}

double mean_of(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// χ² quantile over its degrees of freedom: the quantile of F(freedom, ∞).
double chi_squared_ratio(std::size_t freedom, double probability) {
    const auto n = static_cast<double>(freedom);
    return boost::math::quantile(boost::math::chi_squared(n), probability) / n;
}

/// Sums of squares of the stems' means about the mean of their stratum.
double means_sum_of_squares(std::span<const StemTests> stems, std::size_t& freedom) {
    struct Stratum {
        double sum = 0.0;
        std::size_t count = 0;
    };
    std::map<std::size_t, Stratum> strata;
    for (const StemTests& stem : stems) {
        Stratum& stratum = strata[stem.stratum];
        stratum.sum += mean_of(stem.values);
        ++stratum.count;
    }
    double squares = 0.0;
    for (const StemTests& stem : stems) {
        const Stratum& stratum = strata[stem.stratum];
        const double distance =
            mean_of(stem.values) - stratum.sum / static_cast<double>(stratum.count);
        squares += distance * distance;
    }
    freedom = stems.size() - strata.size();
    return squares;
}

/// Ting et al. (1990), as in Burdick & Graybill (1992), Confidence Intervals on Variance
/// Components, section 3.3: (MS_between − MS_within)/tests.
Bounds between_interval(const VarianceComponents& c, double between_square) {
    // The bounds of a difference p − q of mean squares, exact where either variance is zero; the
    // mixed coefficients g12 and h12 make them exact where both are equal.
    const auto a = static_cast<double>(c.between.degrees_of_freedom);
    const auto b = static_cast<double>(c.within.degrees_of_freedom);
    const boost::math::fisher_f f(a, b);
    const double f_high = boost::math::quantile(f, 1.0 - tail);
    const double f_low = boost::math::quantile(f, tail);
    const double g1 = 1.0 - 1.0 / chi_squared_ratio(c.between.degrees_of_freedom, 1.0 - tail);
    const double h2 = 1.0 / chi_squared_ratio(c.within.degrees_of_freedom, tail) - 1.0;
    const double g12 =
        ((f_high - 1.0) * (f_high - 1.0) - g1 * g1 * f_high * f_high - h2 * h2) / f_high;
    const double h1 = 1.0 / chi_squared_ratio(c.between.degrees_of_freedom, tail) - 1.0;
    const double g2 = 1.0 - 1.0 / chi_squared_ratio(c.within.degrees_of_freedom, 1.0 - tail);
    const double h12 = ((1.0 - f_low) * (1.0 - f_low) - h1 * h1 * f_low * f_low - g2 * g2) / f_low;
    const double p = between_square;
    const double q = c.within.variance;
    const double below = g1 * g1 * p * p + h2 * h2 * q * q + g12 * p * q;
    const double above = h1 * h1 * p * p + g2 * g2 * q * q + h12 * p * q;
    const double difference = p - q;
    return {std::max(0.0, (difference - std::sqrt(std::max(0.0, below))) / c.tests_per_stem),
            std::max(0.0, (difference + std::sqrt(std::max(0.0, above))) / c.tests_per_stem)};
}

/// `between_square` is the mean square of the stems' means, times the harmonic mean of their tests.
void tell_between(VarianceComponents& c, double between_square) {
    c.between.variance = std::max(0.0, (between_square - c.within.variance) / c.tests_per_stem);
    c.between.interval = between_interval(c, between_square);
    // Share of the variance that lies between stems.
    c.intraclass_correlation.value = c.between.variance / (c.between.variance + c.within.variance);
    c.f_statistic = between_square / c.within.variance;
    c.p_value =
        fisher_f_p_value(c.f_statistic, c.between.degrees_of_freedom, c.within.degrees_of_freedom);
    const boost::math::fisher_f f(static_cast<double>(c.between.degrees_of_freedom),
                                  static_cast<double>(c.within.degrees_of_freedom));
    // F/F_quantile bounds the ratio of expected mean squares, 1 + tests · between/within.
    const auto share = [&](double quantile) {
        const double ratio = c.f_statistic / quantile;
        return std::max(0.0, (ratio - 1.0) / (ratio - 1.0 + c.tests_per_stem));
    };
    c.intraclass_correlation.interval = {share(boost::math::quantile(f, 1.0 - tail)),
                                         share(boost::math::quantile(f, tail))};
}

} // namespace

double quantile(std::span<const double> ascending, double share) {
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

VarianceComponents variance_components(std::span<const StemTests> stems) {
    VarianceComponents c;
    c.between.variance = c.within.variance = c.intraclass_correlation.value = c.f_statistic =
        c.p_value = unknown;
    c.between.interval = c.within.interval = c.intraclass_correlation.interval = {unknown, unknown};
    c.stems = stems.size();
    double squares_within = 0.0;
    double reciprocals = 0.0;
    for (const StemTests& stem : stems) {
        const double mean = mean_of(stem.values);
        for (const double value : stem.values)
            squares_within += (value - mean) * (value - mean);
        c.tests += stem.values.size();
        reciprocals += 1.0 / static_cast<double>(stem.values.size());
    }
    c.within.degrees_of_freedom = c.tests - c.stems;
    if (c.within.degrees_of_freedom == 0) {
        c.reason = "no stem was tested twice";
        return c;
    }
    // Unweighted means (Thomas & Hultquist 1978): stems with different numbers of tests count as if
    // each had their harmonic mean.
    c.tests_per_stem = static_cast<double>(c.stems) / reciprocals;
    const double f = static_cast<double>(c.within.degrees_of_freedom);
    c.within.variance = squares_within / f;
    const boost::math::chi_squared distribution(f);
    c.within.interval = {squares_within / boost::math::quantile(distribution, 1.0 - tail),
                         squares_within / boost::math::quantile(distribution, tail)};
    const double of_means = means_sum_of_squares(stems, c.between.degrees_of_freedom);
    if (c.between.degrees_of_freedom == 0) {
        c.reason = "no two stems are of the same design point";
        return c;
    }
    if (!(c.within.variance > 0.0)) {
        c.reason = "the tests of each stem agree exactly";
        c.between.variance = of_means / static_cast<double>(c.between.degrees_of_freedom);
        return c;
    }
    tell_between(c,
                 c.tests_per_stem * of_means / static_cast<double>(c.between.degrees_of_freedom));
    return c;
}

} // namespace culm::reduce
