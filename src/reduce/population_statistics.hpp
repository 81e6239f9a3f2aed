// SPDX-License-Identifier: BSD-3-Clause
// Descriptive statistics of samples: moments with intervals, quantiles; components of the
// variance, between stems and between tests of one stem.
#pragma once

#include "reduce/distributions.hpp"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace culm::reduce {

/// Intervals have a coverage of 95 % for a normal population.
struct SampleSummary {
    std::size_t count = 0;
    double mean = 0.0;
    Bounds mean_interval;               ///< Student's t
    double standard_deviation = 0.0;    ///< with count − 1
    Bounds standard_deviation_interval; ///< χ²
    double lowest = 0.0;
    double highest = 0.0;
    double median = 0.0;
    Bounds central_90_percent; ///< the 5 % and 95 % quantiles of the sample, interpolated
};

template <class To>
void describe(To& to, const SampleSummary& sample) {
    to("count", sample.count);
    to("mean", sample.mean);
    to("mean_interval", sample.mean_interval);
    to("standard_deviation", sample.standard_deviation);
    to("standard_deviation_interval", sample.standard_deviation_interval);
    to("lowest", sample.lowest);
    to("median", sample.median);
    to("highest", sample.highest);
    to("central_90_percent", sample.central_90_percent);
}

/// Finite values; NaN where the sample is too small for a number (one value has no spread).
[[nodiscard]] SampleSummary summarise(std::span<const double> values);

/// Quantile of ascending values, interpolated between order statistics (type 7 of Hyndman & Fan
/// 1996). `share` in 0 … 1; at least one value.
[[nodiscard]] double quantile(std::span<const double> ascending, double share);

/// Straight line y = intercept + slope x.
struct LineFit {
    std::size_t count = 0;
    double intercept = 0.0;
    double slope = 0.0;
    double slope_error = 0.0;
    Bounds slope_interval;
    double correlation = 0.0; ///< Pearson's; of weighted points with the weights
    double p_value = 1.0;     ///< of a slope of zero, Student's t
};

template <class To>
void describe(To& to, const LineFit& line) {
    to("points", line.count);
    to("intercept", line.intercept);
    to("slope", line.slope);
    to("stderr", line.slope_error);
    to("interval", line.slope_interval);
    to("correlation", line.correlation);
    to("p_value", line.p_value);
}

/// Least squares; `weights` (empty: equal) are inverse variances up to a common factor, which the
/// scatter about the line determines. Fewer than three points or one x only: count 0.
[[nodiscard]] LineFit fit_line(std::span<const double> x, std::span<const double> y,
                               std::span<const double> weights = {});

/// p-values adjusted for their number (Holm 1979): an adjusted value below α keeps the probability
/// of any false alarm among them below α, whatever their dependence.
[[nodiscard]] std::vector<double> holm_adjusted(std::span<const double> p_values);

/// A variance with its interval.
struct VarianceComponent {
    double variance = 0.0;
    Bounds interval;
    std::size_t degrees_of_freedom = 0;
};

template <class To>
void describe(To& to, const VarianceComponent& component) {
    to("variance", component.variance);
    to("interval", component.interval);
    to("degrees_of_freedom", component.degrees_of_freedom);
}

/// A share of the variance with its 95 % interval.
struct Share {
    double value = 0.0;
    Bounds interval;
};

template <class To>
void describe(To& to, const Share& share) {
    to("value", share.value);
    to("interval", share.interval);
}

/// The tests of one stem.
struct StemTests {
    std::size_t stratum = 0;    ///< stems are compared with stems of the same stratum only
    std::vector<double> values; ///< at least one, all finite
};

/// The one-way random-effects model y_ij = μ + a_i + e_ij: Var(a) between stems, Var(e) between
/// tests of one stem. Where strata differ, each has its own μ. Quantities for which the sample is
/// too small are NaN.
struct VarianceComponents {
    std::size_t stems = 0;
    std::size_t tests = 0;
    double tests_per_stem = 0.0; ///< harmonic mean
    VarianceComponent between;   ///< negative estimates are set to zero
    VarianceComponent within;
    Share intraclass_correlation; ///< between / (between + within)
    double f_statistic = 0.0;     ///< of the test that stems do not differ
    double p_value = 1.0;
    std::string reason; ///< one sentence if `between` or `within` is not identifiable
};

template <class To>
void describe(To& to, const VarianceComponents& found) {
    to("stems", found.stems);
    to("tests", found.tests);
    to("between", found.between);
    to("within", found.within);
    to("intraclass_correlation", found.intraclass_correlation);
    to("f", found.f_statistic);
    to("p_value", found.p_value);
    to.when(!found.reason.empty(), [&] { to("reason", found.reason); });
}

/// Analysis of variance with unweighted means of the stems (Thomas & Hultquist 1978); for equal
/// numbers of tests it is the ordinary one. 95 % intervals: χ² for `within`, the modified
/// large-sample method of Ting et al. (1990) for `between`, F for the intraclass correlation; all
/// assume normal effects.
[[nodiscard]] VarianceComponents variance_components(std::span<const StemTests> stems);

} // namespace culm::reduce
