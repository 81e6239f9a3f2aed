// SPDX-License-Identifier: BSD-3-Clause
// Estimates with intervals, tail probabilities and quantiles for the intervals and tests of this
// layer, and tests whether residuals are noise: of correlation, of runs, and against a known noise.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace culm::reduce {

/// Two-sided 95 % quantile of the standard normal distribution.
inline constexpr double normal_quantile_95 = 1.959964;

/// Coverage of every interval that this layer reports.
inline constexpr double confidence_level = 0.95;

/// Half-width of the two-sided interval of coverage `confidence_level`, in standard errors: the
/// quantile of Student's t distribution. Throws std::domain_error unless degrees_of_freedom > 0.
[[nodiscard]] double student_t_factor(std::size_t degrees_of_freedom);

struct Bounds {
    double lower = 0.0;
    double upper = 0.0;
};

/// An estimated number; the interval has the coverage `confidence_level`.
struct Estimate {
    double value = 0.0;
    double standard_error = 0.0;
    double lower = 0.0;
    double upper = 0.0;

    [[nodiscard]] Bounds interval() const { return {lower, upper}; }
};

template <class To>
void describe(To& to, const Estimate& found) {
    to("value", found.value);
    to("stderr", found.standard_error);
    to("interval", found.interval(), "95 %");
}

/// With the interval of a normal distribution.
[[nodiscard]] Estimate normal_estimate(double value, double standard_error);
/// With an interval of `factor` standard errors to either side; a negative variance counts as zero.
[[nodiscard]] Estimate estimate(double value, double variance, double factor);

/// P(|T| >= |t|) for Student's t distribution; 0 for an infinite t.
[[nodiscard]] double student_t_p_value(double t, std::size_t degrees_of_freedom);

/// P(X >= f) for Fisher's F distribution with the degrees of freedom of the numerator and of the
/// denominator; 0 for an infinite f, 1 for f <= 0.
[[nodiscard]] double fisher_f_p_value(double f, std::size_t numerator, std::size_t denominator);

/// Autocovariance (1/n) Σ e_t e_{t+lag} of values of mean zero, for lags 0 … largest_lag; shape
/// (largest_lag + 1). Lags of n and more give 0.
[[nodiscard]] std::vector<double> autocovariance(std::span<const double> values,
                                                 std::size_t largest_lag);

/// Σ w(lag) Σ_t (a_t a_{t+lag}ᵀ + transpose) over the rows a of `rows`; lag 0 once.
[[nodiscard]] Eigen::MatrixXd lagged_sum(const Eigen::MatrixXd& rows,
                                         std::span<const double> weights);

/// 1 − lag/(lags + 1) for lags 0 … `lags`.
[[nodiscard]] std::vector<double> bartlett_weights(std::size_t lags);

/// p-value of the test of Ljung & Box (1978) that residuals are uncorrelated up to `lags`, with the
/// statistic's distribution for finite numbers of residuals. 1 if all residuals are equal or their
/// number does not exceed `lags`.
[[nodiscard]] double ljung_box_p_value(std::span<const double> residuals, std::size_t lags);

/// Two-sided p-value of the test of Wald & Wolfowitz (1940) that the signs of residuals are in
/// random order (normal approximation). Zeros are left out; 1 with fewer than two of each sign.
[[nodiscard]] double runs_p_value(std::span<const double> residuals);

/// P(χ² >= value) for any positive number of degrees of freedom.
[[nodiscard]] double chi_squared_p_value(double value, double degrees_of_freedom);

} // namespace culm::reduce
