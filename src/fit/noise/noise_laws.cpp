// SPDX-License-Identifier: BSD-3-Clause
#include "fit/noise/noise_laws.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>

#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/special_functions/gamma.hpp>
#include <boost/math/tools/minima.hpp>
#include <fmt/core.h>
#include <unsupported/Eigen/FFT>

namespace culm::fit {
namespace {

/// Significance level of a property of the noise: noise without it would show as much in one
/// recording of a thousand.
constexpr double significance = 1e-3;
/// Student's t with more degrees of freedom is a Gaussian for every practical purpose.
constexpr double most_degrees = 15.0;

/// Does a gain of log-likelihood by one more number show a property of the noise?
bool is_significant(double gain) {
    return gain > 0.0 && boost::math::gamma_q(0.5, gain) < significance;
}

/// Errors over the noise on a fine grid, with the number of errors at each point.
using Counts = std::map<double, double>;

/// The scale of maximum likelihood, and the logarithm of the likelihood.
template <class Law>
std::pair<double, double> best_scale(const Counts& errors, const Law& law, double about) {
    constexpr int digits = 12; // binary: 2e-4 of the logarithm, far below its uncertainty
    const auto negative = [&](double logarithm) {
        double sum = 0.0;
        for (const auto& [error, count] : errors)
            sum += count * (std::log(pdf(law, error * std::exp(-logarithm))) - logarithm);
        return -sum;
    };
    const auto [logarithm, smallest] = boost::math::tools::brent_find_minima(
        negative, std::log(0.1 * about), std::log(2.0 * about), digits);
    return {std::exp(logarithm), -smallest};
}

} // namespace

double Tails::scored(double error) const {
    if (!is_heavy)
        return error;
    const double z = error / scale;
    return scale * (degrees + 1.0) * z / (degrees + z * z) / slope;
}

Tails tails_of(const std::vector<double>& values) {
    const auto count = static_cast<double>(values.size());
    const double deviation =
        std::sqrt(std::inner_product(values.begin(), values.end(), values.begin(), 0.0) / count);
    const double grid = 0.05 * deviation; // too fine to matter, with few points
    Counts errors;
    for (const double value : values)
        errors[grid * std::round(value / grid)] += 1.0;
    // The Gaussian has its best scale in closed form.
    Tails best;
    best.scale = deviation;
    const double gaussian =
        -count * (std::log(deviation) + 0.5 * std::log(2.0 * std::numbers::pi) + 0.5);
    for (const double degrees : {2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 8.0, 12.0, 20.0}) {
        const auto [scale, likelihood] =
            best_scale(errors, boost::math::students_t(degrees), deviation);
        if (likelihood - gaussian > best.gain) {
            best.degrees = degrees;
            best.scale = scale;
            best.gain = likelihood - gaussian;
        }
    }
    best.is_heavy =
        best.degrees < most_degrees && boost::math::gamma_q(0.5, best.gain) < significance;
    if (best.is_heavy) {
        double sum = 0.0;
        for (const double value : values) {
            const double square = std::pow(value / best.scale, 2);
            sum +=
                (best.degrees + 1.0) * (best.degrees - square) / std::pow(best.degrees + square, 2);
        }
        best.slope = sum / count;
    }
    return best;
}

Eigen::ArrayXd spectrum_of(double correlation, const std::vector<Eigen::Index>& bins,
                           Eigen::Index frames) {
    Eigen::ArrayXd out(static_cast<Eigen::Index>(bins.size()));
    for (std::size_t k = 0; k < bins.size(); ++k) {
        const double turn =
            2.0 * std::numbers::pi * static_cast<double>(bins[k]) / static_cast<double>(frames);
        out(static_cast<Eigen::Index>(k)) =
            (1.0 - correlation * correlation) /
            (1.0 - 2.0 * correlation * std::cos(turn) + correlation * correlation);
    }
    return out;
}

SlowNoise slow_noise_of(const Eigen::ArrayXd& power, double copies,
                        const std::vector<Eigen::Index>& bins, Eigen::Index frames) {
    constexpr double largest_correlation = 0.995;
    constexpr int digits = 12; // binary
    const auto negative = [&](double correlation) {
        const Eigen::ArrayXd shape = spectrum_of(correlation, bins, frames);
        return copies * (shape.log() + std::log((power / shape).mean())).sum();
    };
    const auto [correlation, smallest] =
        boost::math::tools::brent_find_minima(negative, 0.0, largest_correlation, digits);
    const double gain = negative(0.0) - smallest;
    if (!is_significant(gain))
        return {power.mean(), 0.0};
    return {(power / spectrum_of(correlation, bins, frames)).mean(), correlation};
}

TimingNoise timing_noise_of(const std::vector<double>& errors, const std::vector<double>& rates) {
    constexpr double decades = 4.0; // of the ratio of the two parts, to either side
    constexpr int digits = 20;      // binary
    const Eigen::Map<const Eigen::ArrayXd> error(errors.data(), std::ssize(errors));
    const Eigen::Map<const Eigen::ArrayXd> rate(rates.data(), std::ssize(rates));
    const double mean_square = error.size() > 0 ? rate.square().mean() : 0.0;
    if (!(mean_square > 0.0))
        return {};
    const auto negative = [&](double ratio) { // of the variances at the mean square rate
        const Eigen::ArrayXd growth = 1.0 + ratio / mean_square * rate.square();
        return 0.5 * (growth.log() + std::log((error.square() / growth).mean())).sum();
    };
    const auto [logarithm, smallest] = boost::math::tools::brent_find_minima(
        [&](double exponent) { return negative(std::pow(10.0, exponent)); }, -decades, decades,
        digits);
    const double gain = negative(0.0) - smallest;
    if (!is_significant(gain))
        return {};
    const double ratio = std::pow(10.0, logarithm);
    const double deviation =
        std::sqrt((error.square() / (1.0 + ratio / mean_square * rate.square())).mean());
    return {deviation, deviation * std::sqrt(ratio / mean_square)};
}

Eigen::MatrixXcd fourier_coefficients(const Eigen::MatrixXd& rest,
                                      const std::vector<Eigen::Index>& bins,
                                      const Eigen::ArrayXd& left) {
    Eigen::FFT<double> transform;
    Eigen::MatrixXcd out(static_cast<Eigen::Index>(bins.size()), rest.cols());
    for (Eigen::Index j = 0; j < rest.cols(); ++j) {
        const std::vector<double> values(rest.col(j).begin(), rest.col(j).end());
        std::vector<std::complex<double>> found;
        transform.fwd(found, values);
        for (std::size_t k = 0; k < bins.size(); ++k)
            out(static_cast<Eigen::Index>(k), j) =
                found[static_cast<std::size_t>(bins[k])] /
                std::sqrt(left(bins[k]) * static_cast<double>(rest.rows()));
    }
    return out;
}

double common_share_of(const Eigen::MatrixXcd& found) {
    const auto rows = static_cast<double>(found.cols());
    if (rows < 2.0)
        return 0.0;
    const auto bins = static_cast<double>(found.rows());
    const Eigen::MatrixXd covariance = (found.adjoint() * found).real();
    const double pairs = 0.5 * rows * (rows - 1.0);
    const double share = (covariance.sum() / covariance.trace() - 1.0) / (rows - 1.0);
    // The real part of n products of independent complex coefficients has the variance n/2.
    const double score = share * std::sqrt(2.0 * bins * pairs);
    return boost::math::cdf(complement(boost::math::normal(), score)) < significance
               ? std::min(share, 0.99)
               : 0.0;
}

double independent_rows(double common_share, double rows) {
    const double largest = 1.0 + (rows - 1.0) * common_share;
    const double others = 1.0 - common_share;
    return rows * rows / (largest * largest + (rows - 1.0) * others * others);
}

std::string in_words(const NoiseModel& model, const Tails& tails, double noise,
                     const measure::ReadingUnit& unit, const std::string& source) {
    std::string text =
        fmt::format("{:.4g} {} in motion ({})", unit.factor * noise, unit.name, source);
    if (model.time_uncertainty > 0.0)
        text += fmt::format(", of which time stamps that are uncertain by {:.2g} ms cause a part",
                            1e3 * model.time_uncertainty);
    if (tails.is_heavy)
        text +=
            fmt::format(", with outliers (Student's t of {:g} degrees of freedom)", tails.degrees);
    if (model.correlation > 0.0)
        text += fmt::format(", correlated by {:.2f} from frame to frame", model.correlation);
    if (model.common_share > 0.0)
        text += fmt::format(" and by {:.2f} from row to row", model.common_share);
    return text;
}

} // namespace culm::fit
