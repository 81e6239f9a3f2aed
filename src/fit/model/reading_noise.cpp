// SPDX-License-Identifier: BSD-3-Clause
#include "fit/model/reading_noise.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <iterator>
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

constexpr std::size_t fewest_degrees_of_freedom = 20;

/// A sum of squares with its degrees of freedom.
struct Scatter {
    double sum_of_squares = 0.0;
    std::size_t degrees_of_freedom = 0;

    [[nodiscard]] double deviation() const {
        return std::sqrt(sum_of_squares / static_cast<double>(degrees_of_freedom));
    }
};

/// Rows with a common noise: all rows of a camera; each sensor has its own.
std::size_t rows_of_one_noise(const measure::Measurement& measurement) {
    return measurement.sensors.empty() ? measurement.heights.size() : 1;
}

/// Scatter about the mean of each row from `first` on that has the same noise, in frames [begin,
/// end).
Scatter scatter_about_means(const measure::Measurement& measurement, std::size_t first,
                            std::size_t begin, std::size_t end) {
    Scatter scatter;
    for (std::size_t j = first; j < first + rows_of_one_noise(measurement); ++j) {
        double sum = 0.0;
        double sum_of_squares = 0.0;
        std::size_t count = 0;
        for (std::size_t i = begin; i < end; ++i) {
            const double reading = measurement.deflection(i, j);
            if (std::isnan(reading))
                continue;
            const double mean = count == 0 ? reading : sum / static_cast<double>(count);
            sum += reading;
            ++count;
            sum_of_squares += (reading - mean) * (reading - sum / static_cast<double>(count));
        }
        if (count > 1) {
            scatter.sum_of_squares += sum_of_squares;
            scatter.degrees_of_freedom += count - 1;
        }
    }
    return scatter;
}

/// Scatter of the second differences, which are insensitive to a slow motion. White noise has 6
/// times its variance in them.
Scatter scatter_of_second_differences(const measure::Measurement& measurement, std::size_t first,
                                      std::size_t begin, std::size_t end) {
    Scatter scatter;
    for (std::size_t j = first; j < first + rows_of_one_noise(measurement); ++j)
        for (std::size_t i = begin + 2; i < end; ++i) {
            const double difference = measurement.deflection(i, j) -
                                      2.0 * measurement.deflection(i - 1, j) +
                                      measurement.deflection(i - 2, j);
            if (std::isnan(difference))
                continue;
            scatter.sum_of_squares += difference * difference / 6.0;
            ++scatter.degrees_of_freedom;
        }
    return scatter;
}

/// Root mean square of the stated uncertainties of each row's readings, (rows), m.
std::vector<double> mean_uncertainties(const measure::Measurement& measurement) {
    const std::size_t rows = measurement.heights.size();
    std::vector<double> means;
    for (std::size_t j = 0; j < rows; ++j) {
        double sum = 0.0;
        double count = 0.0;
        for (std::size_t at = j; at < measurement.deflections.size(); at += rows)
            if (!std::isnan(measurement.deflections[at])) {
                sum += std::pow(measurement.reading_uncertainties[at], 2);
                count += 1.0;
            }
        means.push_back(std::sqrt(sum / std::max(count, 1.0)));
    }
    return means;
}

/// (rows); empty if the first `held` frames do not determine it.
std::vector<double> noise_while_held(const measure::Measurement& measurement, std::size_t held) {
    std::vector<double> noise;
    const std::size_t rows = rows_of_one_noise(measurement);
    for (std::size_t first = 0; first < measurement.heights.size(); first += rows) {
        const Scatter before = scatter_about_means(measurement, first, 0, held);
        if (before.degrees_of_freedom < fewest_degrees_of_freedom || !(before.sum_of_squares > 0.0))
            return {};
        noise.insert(noise.end(), rows, before.deviation());
    }
    return noise;
}

/// (rows); empty if the stem is not at rest in the frames from `begin` on.
std::vector<double> noise_at_rest(const measure::Measurement& measurement, std::size_t begin) {
    const std::size_t end = measurement.times.size();
    std::vector<double> noise;
    const std::size_t rows = rows_of_one_noise(measurement);
    for (std::size_t first = 0; first < measurement.heights.size(); first += rows) {
        const Scatter about_mean = scatter_about_means(measurement, first, begin, end);
        const Scatter differences = scatter_of_second_differences(measurement, first, begin, end);
        if (differences.degrees_of_freedom < 2 * fewest_degrees_of_freedom ||
            !(differences.sum_of_squares > 0.0) ||
            !(about_mean.deviation() < 1.2 * differences.deviation()))
            return {};
        noise.insert(noise.end(), rows, about_mean.deviation());
    }
    return noise;
}

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

ReadingNoise reading_noise(const ObservedRecording& measurement) {
    const std::size_t rows = measurement.heights.size();
    const std::size_t frames = measurement.times.size();
    ReadingNoise noise;
    if (measurement.noise_model && !measurement.noise_model->by_row.empty())
        return {measurement.noise_model->by_row, measurement.noise_model->source};
    if (!measurement.reading_uncertainties.empty() && !measurement.noise_model)
        return {mean_uncertainties(measurement), "stated for every reading"};
    for (std::size_t j = 0; j < rows; ++j)
        if (const auto stated = measurement.noise_at(j); stated && *stated > 0.0)
            noise.by_row.push_back(*stated);
    if (noise.by_row.size() == rows && rows > 0) {
        noise.source =
            measurement.noise_source.empty() ? "stated" : "stated: " + measurement.noise_source;
        return noise;
    }
    noise.by_row.clear();

    // The frame at the release itself, and the one before it, may already have moved.
    std::size_t held = 0;
    while (held < frames && measurement.times[held] < 0.0)
        ++held;
    held -= held > 0 ? 1 : 0;
    if (noise.by_row = noise_while_held(measurement, held); !noise.by_row.empty()) {
        noise.source = fmt::format("{} frames while the stem was held", held);
        return noise;
    }
    const std::size_t tail = frames / 10;
    if (noise.by_row = noise_at_rest(measurement, frames - tail); !noise.by_row.empty())
        noise.source = fmt::format("the last {} frames, at rest", tail);
    return noise;
}

std::vector<double> relative_noise(const measure::Measurement& measurement,
                                   const std::vector<double>& by_row) {
    std::vector<double> relative = measurement.reading_uncertainties;
    for (std::size_t at = 0; at < relative.size(); ++at)
        relative[at] /= by_row[at % by_row.size()];
    return relative;
}

ReadingWeights::ReadingWeights(std::vector<double> noise, std::shared_ptr<const NoiseModel> model,
                               std::vector<bool> is_seen)
    : noise_(std::move(noise)), model_(std::move(model)), is_seen_(std::move(is_seen)) {}

void ReadingWeights::apply(std::span<double> values) const {
    const bool is_relative = model_ && !model_->relative.empty();
    for (std::size_t at = 0; at < values.size(); ++at) {
        const double noise =
            noise_[at % noise_.size()] * (is_relative ? model_->relative[at] : 1.0);
        values[at] = is_seen_[at] && std::isfinite(values[at]) ? values[at] / noise : 0.0;
    }
    if (model_ && model_->common_share > 0.0)
        separate_rows(values);
    if (model_ && model_->correlation > 0.0)
        separate_frames(values);
}

// The covariance of m rows is (1 − c) I + c 1 1ᵀ: 1 + (m − 1) c along their mean, 1 − c across it.
void ReadingWeights::separate_rows(std::span<double> values) const {
    const double share = model_->common_share;
    const std::size_t rows = noise_.size();
    for (std::size_t first = 0; first < values.size(); first += rows) {
        double sum = 0.0;
        double seen = 0.0;
        for (std::size_t at = first; at < first + rows; ++at)
            if (is_seen_[at]) {
                sum += values[at];
                seen += 1.0;
            }
        if (seen == 0.0)
            continue;
        const double along = std::sqrt((1.0 - share) / (1.0 + (seen - 1.0) * share));
        for (std::size_t at = first; at < first + rows; ++at)
            if (is_seen_[at])
                values[at] = (values[at] - (1.0 - along) * sum / seen) / std::sqrt(1.0 - share);
    }
}

// The last reading predicts the one k frames later with the variance 1 − ρ²ᵏ.
void ReadingWeights::separate_frames(std::span<double> values) const {
    for (std::size_t row = 0; row < noise_.size(); ++row) {
        double last = 0.0;
        double carried = 0.0; // correlation with the last reading that was seen
        for (std::size_t at = row; at < values.size(); at += noise_.size()) {
            carried *= model_->correlation;
            if (!is_seen_[at])
                continue;
            const double own = values[at];
            values[at] = (own - carried * last) / std::sqrt(1.0 - carried * carried);
            last = own;
            carried = 1.0;
        }
    }
}

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
