// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/distributions.hpp"

#include <algorithm>
#include <cmath>

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/special_functions/gamma.hpp>

namespace culm::reduce {

namespace {

/// For many lags the statistic is wider and more skewed than χ² with `lags` degrees of freedom: for
/// 220 values and 40 lags, p-values below 1e-4 by χ² occur twenty times too often. Its mean is
/// `lags`; its variance and skewness were fitted to simulations of white noise (60 to 800 values,
/// lags up to a fifth of them). A shifted gamma distribution (Pearson's type III) with these three
/// moments has tail probabilities down to 1e-4 that are right within a factor of two.
double ljung_box_tail(double value, double n, double lags) {
    const double variance = 2.0 * lags * (1.0 + 2.0 * lags / n - 4.0 / n);
    const double skewness =
        std::sqrt(8.0 / lags) * (1.0 + 6.5 * lags / n * std::max(0.0, 1.0 - 17.0 / n));
    const double deviation = std::sqrt(std::max(variance, lags));
    const double shape = 4.0 / (skewness * skewness);
    const double start = lags - 2.0 * deviation / skewness;
    const double place = 2.0 * (value - start) / (deviation * skewness);
    return place > 0.0 ? boost::math::gamma_q(shape, place) : 1.0;
}

} // namespace

double student_t_factor(std::size_t degrees_of_freedom) {
    const boost::math::students_t distribution(static_cast<double>(degrees_of_freedom));
    const double tail = 0.5 * (1.0 - confidence_level);
    return boost::math::quantile(boost::math::complement(distribution, tail));
}

Estimate normal_estimate(double value, double standard_error) {
    const double half = normal_quantile_95 * standard_error;
    return {value, standard_error, value - half, value + half};
}

Estimate estimate(double value, double variance, double factor) {
    const double error = std::sqrt(std::max(variance, 0.0));
    return {value, error, value - factor * error, value + factor * error};
}

double student_t_p_value(double t, std::size_t degrees_of_freedom) {
    if (std::isinf(t))
        return 0.0;
    const boost::math::students_t distribution(static_cast<double>(degrees_of_freedom));
    return 2.0 * boost::math::cdf(boost::math::complement(distribution, std::abs(t)));
}

double fisher_f_p_value(double f, std::size_t numerator, std::size_t denominator) {
    if (f <= 0.0)
        return 1.0;
    if (std::isinf(f))
        return 0.0;
    const boost::math::fisher_f distribution(static_cast<double>(numerator),
                                             static_cast<double>(denominator));
    return boost::math::cdf(boost::math::complement(distribution, f));
}

std::vector<double> autocovariance(std::span<const double> values, std::size_t largest_lag) {
    std::vector<double> covariance(largest_lag + 1, 0.0);
    for (std::size_t lag = 0; lag <= largest_lag && lag < values.size(); ++lag) {
        for (std::size_t t = 0; t + lag < values.size(); ++t)
            covariance[lag] += values[t] * values[t + lag];
        covariance[lag] /= static_cast<double>(values.size());
    }
    return covariance;
}

Eigen::MatrixXd lagged_sum(const Eigen::MatrixXd& rows, std::span<const double> weights) {
    const Eigen::Index n = rows.rows();
    Eigen::MatrixXd sum = weights[0] * (rows.transpose() * rows);
    for (std::size_t lag = 1; lag < weights.size(); ++lag) {
        const auto shift = static_cast<Eigen::Index>(lag);
        if (shift >= n)
            break;
        const Eigen::MatrixXd product =
            rows.topRows(n - shift).transpose() * rows.bottomRows(n - shift);
        sum += weights[lag] * (product + product.transpose());
    }
    return sum;
}

std::vector<double> bartlett_weights(std::size_t lags) {
    std::vector<double> weights;
    for (std::size_t lag = 0; lag <= lags; ++lag)
        weights.push_back(1.0 - static_cast<double>(lag) / static_cast<double>(lags + 1));
    return weights;
}

double ljung_box_p_value(std::span<const double> residuals, std::size_t lags) {
    const std::vector<double> covariance = autocovariance(residuals, lags);
    if (residuals.size() <= lags || lags == 0 || !(covariance[0] > 0.0))
        return 1.0;
    const auto n = static_cast<double>(residuals.size());
    double sum = 0.0;
    for (std::size_t lag = 1; lag <= lags; ++lag) {
        const double correlation = covariance[lag] / covariance[0];
        sum += correlation * correlation / (n - static_cast<double>(lag));
    }
    return ljung_box_tail(n * (n + 2.0) * sum, n, static_cast<double>(lags));
}

double runs_p_value(std::span<const double> residuals) {
    double positive = 0.0;
    double negative = 0.0;
    double runs = 0.0;
    double last = 0.0;
    for (const double residual : residuals) {
        if (residual == 0.0)
            continue;
        (residual > 0.0 ? positive : negative) += 1.0;
        if (residual * last <= 0.0)
            runs += 1.0;
        last = residual;
    }
    if (positive < 2.0 || negative < 2.0)
        return 1.0;
    const double n = positive + negative;
    const double product = 2.0 * positive * negative;
    const double expected = product / n + 1.0;
    const double variance = product * (product - n) / (n * n * (n - 1.0));
    if (!(variance > 0.0))
        return 1.0;
    const boost::math::normal distribution;
    const double z = std::abs(runs - expected) / std::sqrt(variance);
    return 2.0 * boost::math::cdf(boost::math::complement(distribution, z));
}

double chi_squared_p_value(double value, double degrees_of_freedom) {
    if (!(value > 0.0))
        return 1.0;
    if (std::isinf(value))
        return 0.0;
    const boost::math::chi_squared distribution(degrees_of_freedom);
    return boost::math::cdf(boost::math::complement(distribution, value));
}

} // namespace culm::reduce
