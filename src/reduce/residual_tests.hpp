// SPDX-License-Identifier: BSD-3-Clause
// Tests whether residuals are noise: of correlation, of runs, and against a known noise.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace culm::reduce {

/// Autocovariance (1/n) Σ e_t e_{t+lag} of values of mean zero, for lags 0 … largest_lag; shape
/// (largest_lag + 1). Lags of n and more give 0.
[[nodiscard]] std::vector<double> autocovariance(std::span<const double> values,
                                                 std::size_t largest_lag);

/// p-value of the test of Ljung & Box (1978) that residuals are uncorrelated up to `lags`, with the
/// statistic's distribution for finite numbers of residuals. 1 if all residuals are equal or their
/// number does not exceed `lags`.
[[nodiscard]] double ljung_box_p_value(std::span<const double> residuals, std::size_t lags);

/// Two-sided p-value of the test of Wald & Wolfowitz (1940) that the signs of residuals are in
/// random order (normal approximation). Zeros are left out; 1 with fewer than two of each sign.
[[nodiscard]] double runs_p_value(std::span<const double> residuals);

/// P(χ² >= sum_of_squares/sigma²): p-value of residuals against noise of standard deviation sigma.
[[nodiscard]] double chi_squared_p_value(double sum_of_squares, double sigma,
                                         std::size_t degrees_of_freedom);

} // namespace culm::reduce
