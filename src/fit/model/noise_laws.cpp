// SPDX-License-Identifier: BSD-3-Clause
#include "fit/model/reading_noise.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/special_functions/gamma.hpp>
#include <boost/math/tools/minima.hpp>
#include <fmt/core.h>
#include <unsupported/Eigen/FFT>

namespace culm::fit {

namespace {

/// Of a property of the noise that is taken for there: noise without it shows so much in one
/// recording of a thousand.
constexpr double significance = 1e-3;
/// Tails of more are those of a Gaussian for every practical purpose.
constexpr double most_degrees = 15.0;

} // namespace

double Tails::scored(double error) const {
    if (!is_heavy)
        return error;
    const double z = error / scale;
    return scale * (degrees + 1.0) * z / (degrees + z * z) / slope;
}

namespace {

/// Errors over the noise on a fine grid, with how often each was seen.
using Counts = std::map<double, double>;

/// Of errors that are each known within ± half: the probability of that interval, which is the
/// density where the interval is narrow.
template <class Law>
double interval_likelihood(const Counts& errors, const Law& law, double scale, double half) {
    double sum = 0.0;
    for (const auto& [error, count] : errors) {
        const double size = std::abs(error); // laws are even; far out only the upper tail is exact
        const double probability = half > 0.0 ? cdf(complement(law, (size - half) / scale)) -
                                                    cdf(complement(law, (size + half) / scale))
                                              : pdf(law, size / scale) / scale;
        sum += count * std::log(std::max(probability, std::numeric_limits<double>::min()));
    }
    return sum;
}

/// The scale that makes the errors most likely, and how likely.
template <class Law>
std::pair<double, double> best_scale(const Counts& errors, const Law& law, double half,
                                     double about) {
    constexpr int digits = 12; // binary: 2e-4 of the logarithm, far below what the errors tell
    const auto [log_scale, negative] = boost::math::tools::brent_find_minima(
        [&](double log) { return -interval_likelihood(errors, law, std::exp(log), half); },
        std::log(0.1 * about), std::log(2.0 * about), digits);
    return {std::exp(log_scale), -negative};
}

} // namespace

Tails tails_of(const std::vector<double>& values, double half_step) {
    // Coarse steps leave few values, of whose intervals the probability counts; fine ones do
    // nothing.
    constexpr double fine = 0.25;
    const double half = half_step > fine ? half_step : 0.0;
    const auto count = static_cast<double>(values.size());
    double squares = 0.0;
    for (const double value : values)
        squares += value * value;
    const double deviation = std::sqrt(squares / count);
    const double grid = 0.02 * deviation; // too fine to matter, and there are few of them
    Counts errors;
    for (const double value : values)
        errors[grid * std::round(value / grid)] += 1.0;
    const auto [gaussian_scale, gaussian] =
        best_scale(errors, boost::math::normal(), half, deviation);
    Tails best{std::numeric_limits<double>::infinity(), gaussian_scale};
    double best_likelihood = gaussian;
    for (const double degrees : {2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 8.0, 12.0, 20.0}) {
        const auto [scale, likelihood] =
            best_scale(errors, boost::math::students_t(degrees), half, deviation);
        if (likelihood > best_likelihood) {
            best = {degrees, scale};
            best_likelihood = likelihood;
        }
    }
    best.gain = best_likelihood - gaussian;
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

Eigen::ArrayXd spectrum_of(const measure::NoiseModel::Series& series,
                           const std::vector<Eigen::Index>& bins, Eigen::Index frames) {
    Eigen::ArrayXd out(static_cast<Eigen::Index>(bins.size()));
    const double rho = series.correlation;
    for (std::size_t k = 0; k < bins.size(); ++k) {
        const double turn =
            2.0 * std::numbers::pi * static_cast<double>(bins[k]) / static_cast<double>(frames);
        out(static_cast<Eigen::Index>(k)) = 1.0 - series.correlated_share +
                                            series.correlated_share * (1.0 - rho * rho) /
                                                (1.0 - 2.0 * rho * std::cos(turn) + rho * rho);
    }
    return out;
}

namespace {

/// Whittle's (1953) likelihood of mean periodograms, each the mean of `copies` independent ones,
/// at its best variance, which it sets.
double whittle(const Eigen::ArrayXd& power, double copies, const Eigen::ArrayXd& shape,
               double& variance) {
    // A line that nobody expected stands far above its neighbours: it is no noise, and left out.
    const double most = 1.0 + 8.0 / std::sqrt(copies) + 4.0 / copies;
    Eigen::ArrayXd ratio = power / shape;
    variance = ratio.mean();
    for (int pass = 0; pass < 4; ++pass) {
        const Eigen::Array<bool, Eigen::Dynamic, 1> is_noise = ratio < most * variance;
        variance = is_noise.select(ratio, 0.0).sum() /
                   std::max(1.0, static_cast<double>(is_noise.count()));
    }
    ratio = ratio.min(most * variance);
    return -copies * (shape.log() + std::log(variance) + ratio / variance).sum();
}

} // namespace

measure::NoiseModel::Series series_of(const Eigen::ArrayXd& power, double copies,
                                      const std::vector<Eigen::Index>& bins, Eigen::Index frames) {
    measure::NoiseModel::Series best;
    const double white = whittle(power, copies, Eigen::ArrayXd::Ones(power.size()), best.variance);
    double likelihood = white;
    measure::NoiseModel::Series trial;
    for (const double correlation :
         {0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.75, 0.8, 0.85, 0.9, 0.93, 0.95, 0.97, 0.98, 0.99})
        for (const double share : {1.0, 0.95, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1}) {
            trial.correlation = correlation;
            trial.correlated_share = share;
            const double found =
                whittle(power, copies, spectrum_of(trial, bins, frames), trial.variance);
            if (found > likelihood) {
                best = trial;
                likelihood = found;
            }
        }
    // Two numbers more: χ² of two degrees of freedom has the tail e^(−x/2).
    if (!(std::exp(-(likelihood - white)) < significance))
        static_cast<void>(
            whittle(power, copies, Eigen::ArrayXd::Ones(power.size()), (best = {}).variance));
    return best;
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

bool are_alike(const Eigen::MatrixXd& covariance, double bins) {
    double sum = 0.0;
    double pairs = 0.0;
    for (Eigen::Index a = 0; a < covariance.rows(); ++a)
        for (Eigen::Index b = a + 1; b < covariance.rows(); ++b) {
            sum += 2.0 * bins * covariance(a, b) * covariance(a, b) /
                   (covariance(a, a) * covariance(b, b));
            pairs += 1.0;
        }
    return pairs > 0.0 && boost::math::gamma_q(0.5 * pairs, 0.5 * sum) < significance;
}

double independent_rows(const Eigen::MatrixXcd& found) {
    const Eigen::MatrixXcd directions = found.rowwise().normalized();
    const auto bins = static_cast<double>(found.rows());
    const Eigen::MatrixXd covariance = (directions.adjoint() * directions).real() / bins;
    // By chance independent rows have more of it: the real part of so many complex products.
    const double together = covariance.squaredNorm() / std::pow(covariance.trace(), 2) - 0.5 / bins;
    return std::min(static_cast<double>(found.cols()), 1.0 / std::max(together, 1e-3));
}

std::string in_words(const measure::NoiseModel& model, const Tails& tails, double noise,
                     double step, const std::string& source) {
    double variance = 0.0;
    double correlation = 0.0;
    for (const measure::NoiseModel::Series& each : model.series) {
        variance += each.variance / static_cast<double>(model.series.size());
        correlation = std::max(correlation, each.correlated_share * each.correlation);
    }
    noise *= 1e3 * std::sqrt(variance);
    std::string text = fmt::format("{:.4g} mm in motion ({})", noise, source);
    if (step > 0.0)
        text += fmt::format(", rounded to {:.3g} mm", 1e3 * step);
    if (tails.is_heavy)
        text +=
            fmt::format(", with outliers (Student's t of {:g} degrees of freedom)", tails.degrees);
    if (correlation > 0.0)
        text += fmt::format(", correlated by {:.2f} from frame to frame", correlation);
    if (!model.rotation.empty())
        text += ", in part common to the rows";
    return text;
}

} // namespace culm::fit
