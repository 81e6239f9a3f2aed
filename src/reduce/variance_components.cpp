// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/variance_components.hpp"

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

constexpr double no_estimate = std::numeric_limits<double>::quiet_NaN();
constexpr double tail = 0.5 * (1.0 - confidence_level);

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
    const auto a = static_cast<double>(c.between_degrees_of_freedom);
    const auto b = static_cast<double>(c.within_degrees_of_freedom);
    const boost::math::fisher_f f(a, b);
    const double f_high = boost::math::quantile(f, 1.0 - tail);
    const double f_low = boost::math::quantile(f, tail);
    const double g1 = 1.0 - 1.0 / chi_squared_ratio(c.between_degrees_of_freedom, 1.0 - tail);
    const double h2 = 1.0 / chi_squared_ratio(c.within_degrees_of_freedom, tail) - 1.0;
    const double g12 =
        ((f_high - 1.0) * (f_high - 1.0) - g1 * g1 * f_high * f_high - h2 * h2) / f_high;
    const double h1 = 1.0 / chi_squared_ratio(c.between_degrees_of_freedom, tail) - 1.0;
    const double g2 = 1.0 - 1.0 / chi_squared_ratio(c.within_degrees_of_freedom, 1.0 - tail);
    const double h12 = ((1.0 - f_low) * (1.0 - f_low) - h1 * h1 * f_low * f_low - g2 * g2) / f_low;
    const double p = between_square;
    const double q = c.within;
    const double below = g1 * g1 * p * p + h2 * h2 * q * q + g12 * p * q;
    const double above = h1 * h1 * p * p + g2 * g2 * q * q + h12 * p * q;
    const double difference = p - q;
    return {std::max(0.0, (difference - std::sqrt(std::max(0.0, below))) / c.tests_per_stem),
            std::max(0.0, (difference + std::sqrt(std::max(0.0, above))) / c.tests_per_stem)};
}

/// `between_square` is the mean square of the stems' means, times the harmonic mean of their tests.
void tell_between(VarianceComponents& c, double between_square) {
    c.between = std::max(0.0, (between_square - c.within) / c.tests_per_stem);
    c.between_interval = between_interval(c, between_square);
    // Share of the variance that lies between stems.
    c.intraclass_correlation = c.between / (c.between + c.within);
    c.f_statistic = between_square / c.within;
    c.p_value =
        fisher_f_p_value(c.f_statistic, c.between_degrees_of_freedom, c.within_degrees_of_freedom);
    const boost::math::fisher_f f(static_cast<double>(c.between_degrees_of_freedom),
                                  static_cast<double>(c.within_degrees_of_freedom));
    // F/F_quantile bounds the ratio of expected mean squares, 1 + tests · between/within.
    const auto share = [&](double quantile) {
        const double ratio = c.f_statistic / quantile;
        return std::max(0.0, (ratio - 1.0) / (ratio - 1.0 + c.tests_per_stem));
    };
    c.intraclass_interval = {share(boost::math::quantile(f, 1.0 - tail)),
                             share(boost::math::quantile(f, tail))};
}

} // namespace

VarianceComponents variance_components(std::span<const StemTests> stems) {
    VarianceComponents c;
    c.between = c.within = c.intraclass_correlation = c.f_statistic = c.p_value = no_estimate;
    c.between_interval = c.within_interval = c.intraclass_interval = {no_estimate, no_estimate};
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
    c.within_degrees_of_freedom = c.tests - c.stems;
    if (c.within_degrees_of_freedom == 0) {
        c.reason = "no stem was tested twice";
        return c;
    }
    // Unweighted means (Thomas & Hultquist 1978): stems with different numbers of tests count as if
    // each had their harmonic mean.
    c.tests_per_stem = static_cast<double>(c.stems) / reciprocals;
    const double f = static_cast<double>(c.within_degrees_of_freedom);
    c.within = squares_within / f;
    const boost::math::chi_squared distribution(f);
    c.within_interval = {squares_within / boost::math::quantile(distribution, 1.0 - tail),
                         squares_within / boost::math::quantile(distribution, tail)};
    const double of_means = means_sum_of_squares(stems, c.between_degrees_of_freedom);
    if (c.between_degrees_of_freedom == 0) {
        c.reason = "no two stems are of the same design point";
        return c;
    }
    if (!(c.within > 0.0)) {
        c.reason = "the tests of each stem agree exactly";
        c.between = of_means / static_cast<double>(c.between_degrees_of_freedom);
        return c;
    }
    tell_between(c,
                 c.tests_per_stem * of_means / static_cast<double>(c.between_degrees_of_freedom));
    return c;
}

} // namespace culm::reduce
