// SPDX-License-Identifier: BSD-3-Clause
#include "fit/model/reading_noise.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <boost/math/special_functions/gamma.hpp>

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

Tails tails_of(const std::vector<double>& values) {
    const auto count = static_cast<double>(values.size());
    double squares = 0.0;
    for (const double value : values)
        squares += value * value;
    const double gaussian_scale = std::sqrt(squares / count);
    const double gaussian =
        -count * (std::log(gaussian_scale) + 0.5 + 0.5 * std::log(2.0 * std::numbers::pi));
    Tails best{std::numeric_limits<double>::infinity(), gaussian_scale};
    double best_likelihood = gaussian;
    for (const double degrees : {2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 8.0, 12.0, 20.0}) {
        double variance = squares / count;
        constexpr int passes = 30; // of the EM algorithm for the scale (Lange et al. 1989)
        for (int pass = 0; pass < passes; ++pass) {
            double sum = 0.0;
            for (const double value : values)
                sum += (degrees + 1.0) * value * value / (degrees + value * value / variance);
            variance = sum / count;
        }
        double likelihood =
            count * (std::lgamma(0.5 * (degrees + 1.0)) - std::lgamma(0.5 * degrees) -
                     0.5 * std::log(degrees * std::numbers::pi * variance));
        for (const double value : values)
            likelihood -= 0.5 * (degrees + 1.0) * std::log1p(value * value / (degrees * variance));
        if (likelihood > best_likelihood) {
            best = {degrees, std::sqrt(variance)};
            best_likelihood = likelihood;
        }
    }
    best.is_heavy = best.degrees < most_degrees &&
                    boost::math::gamma_q(0.5, best_likelihood - gaussian) < significance;
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

} // namespace culm::fit
