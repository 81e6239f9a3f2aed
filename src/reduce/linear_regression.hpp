// SPDX-License-Identifier: BSD-3-Clause
// Ordinary least squares with standard errors, intervals and tests.
#pragma once

#include "reduce/distributions.hpp"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace culm::reduce {

/// One fitted coefficient with its 95 % interval and the p-value of the t-test that it is zero.
struct Coefficient : Estimate {
    std::string name;
    double p_value = 1.0;
};

template <class To>
void describe(To& to, const Coefficient& coefficient) {
    to("term", coefficient.name);
    to("coefficient", coefficient.value);
    to("standard_error", coefficient.standard_error);
    to("interval", coefficient.interval());
    to("p_value", coefficient.p_value);
}

struct LinearRegression {
    std::vector<Coefficient> coefficients; ///< (columns), in the order of the design's columns
    std::vector<double> residuals;         ///< (rows), observed − fitted
    double residual_sum_of_squares = 0.0;
    double r_squared = 0.0; ///< about the mean if the design has a constant column, else about zero
    double adjusted_r_squared = 0.0;
    double sigma = 0.0;                   ///< √(RSS / degrees of freedom)
    std::size_t degrees_of_freedom = 0;   ///< rows − columns
    double rounding_sum_of_squares = 0.0; ///< an RSS below this consists of rounding alone
    Eigen::MatrixXd covariance;           ///< (columns, columns), of the coefficients
};

/// A response predicted at a new point: the estimate of one new observation.
struct Prediction : Estimate {
    double mean_standard_error = 0.0; ///< of the mean response
};

/// Least squares by QR with column pivoting of the design scaled to columns of unit length.
/// `design` has the shape (rows, columns), `response` (rows), `names` (columns).
/// Throws core::NumericalError (FitFailed) if the rows do not outnumber the columns, a number is
/// not finite, or the columns are linearly dependent (the text names a dependent one).
[[nodiscard]] LinearRegression regress(Eigen::MatrixXd design, std::span<const double> response,
                                       std::span<const std::string> names);

/// The response at a row of the design, shape (columns).
[[nodiscard]] Prediction predict(const LinearRegression& regression,
                                 std::span<const double> regressors);

/// F-test of a model against a larger one that contains it.
struct NestedTest {
    double f_statistic = 0.0; ///< infinite if the larger model is exact and the smaller is not
    double p_value = 1.0;
    std::size_t numerator_degrees_of_freedom = 0;
    std::size_t denominator_degrees_of_freedom = 0;
};

template <class To>
void describe(To& to, const NestedTest& test) {
    to("f", test.f_statistic);
    to("p_value", test.p_value);
}

/// F = ((RSS_r − RSS_f)/(df_r − df_f)) / (RSS_f/df_f) for two regressions of the same response, the
/// columns of `reduced` a true subset of those of `full`. Differences that consist of rounding
/// alone give F = 0.
[[nodiscard]] NestedTest nested_f_test(const LinearRegression& reduced,
                                       const LinearRegression& full);

} // namespace culm::reduce
