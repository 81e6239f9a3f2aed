// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/correlated_estimate.hpp"

#include "core/error.hpp"
#include "fit/solve/information.hpp"
#include "fit/solve/layout.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace culm::diagnose {
namespace {

constexpr double largest_correlation = 0.99;

/// Calls act(reading before or -1, reading) for what was seen.
template <class Act>
void for_each_reading(const ReadingSequence& sequence, const Act& act) {
    Eigen::Index before = -1;
    for (std::size_t i = 0; i < sequence.readings.size(); ++i) {
        if (sequence.readings[i] >= 0)
            act(before, sequence.readings[i], sequence.first_frame + i);
        before = sequence.readings[i];
    }
}

/// The lag-one autocorrelation, which maximises the likelihood of AR(1) noise to first order.
double correlation_of(const Eigen::VectorXd& residual, const ReadingSequence& sequence) {
    double product = 0.0;
    double square = 0.0;
    std::size_t pairs = 0;
    for_each_reading(sequence, [&](Eigen::Index before, Eigen::Index reading, std::size_t) {
        if (before < 0)
            return;
        product += residual(before) * residual(reading);
        square += residual(before) * residual(before);
        ++pairs;
    });
    const double correlation = square > 0.0 ? product / square : 0.0;
    const double chance = 2.0 / std::sqrt(static_cast<double>(std::max<std::size_t>(pairs, 1)));
    return correlation > chance ? std::min(correlation, largest_correlation) : 0.0;
}

/// What is new in a reading: all of it, scaled alike, where the one before was not seen.
template <class Value>
auto white_part(const Value& values, Eigen::Index before, Eigen::Index reading,
                double correlation) {
    return before < 0 ? (std::sqrt(1.0 - correlation * correlation) * values.row(reading)).eval()
                      : (values.row(reading) - correlation * values.row(before)).eval();
}

} // namespace

CorrelatedNoise correlated_noise(const Eigen::VectorXd& residual,
                                 const std::vector<ReadingSequence>& sequences) {
    CorrelatedNoise noise;
    for (const ReadingSequence& sequence : sequences) {
        const double correlation = correlation_of(residual, sequence);
        double squares = 0.0;
        std::size_t count = 0;
        for_each_reading(sequence, [&](Eigen::Index before, Eigen::Index reading, std::size_t) {
            squares += white_part(residual, before, reading, correlation).squaredNorm();
            ++count;
        });
        const auto readings = static_cast<double>(std::max<std::size_t>(count, 1));
        const double deviation = squares > 0.0 ? std::sqrt(squares / readings) : 1.0;
        noise.correlation.push_back(correlation);
        noise.deviation.push_back(deviation);
        noise.cost += static_cast<double>(count) * std::log(deviation);
    }
    return noise;
}

WhitenedReadings whitened(const StackedReadings& stacked,
                          const std::vector<ReadingSequence>& sequences,
                          const CorrelatedNoise& noise) {
    WhitenedReadings out;
    out.stacked.ids = stacked.ids;
    out.stacked.jacobian.resize(stacked.jacobian.rows(), stacked.jacobian.cols());
    out.stacked.residual.resize(stacked.residual.size());
    Eigen::Index row = 0;
    std::size_t last_frame = 0;
    for (const ReadingSequence& sequence : sequences)
        last_frame = std::max(last_frame, sequence.first_frame + sequence.readings.size());
    for (std::size_t s = 0; s < sequences.size(); ++s)
        for_each_reading(
            sequences[s], [&](Eigen::Index before, Eigen::Index reading, std::size_t frame) {
                const double correlation = noise.correlation[s];
                out.stacked.jacobian.row(row) =
                    white_part(stacked.jacobian, before, reading, correlation) / noise.deviation[s];
                out.stacked.residual.row(row) =
                    white_part(stacked.residual, before, reading, correlation) / noise.deviation[s];
                out.frames.push_back(frame);
                ++row;
            });
    // Constraints of error terms are independent of each other and of all frames.
    for (Eigen::Index k = stacked.readings(); k < stacked.residual.size(); ++k, ++row) {
        out.stacked.jacobian.row(row) = stacked.jacobian.row(k);
        out.stacked.residual(row) = stacked.residual(k);
        out.frames.push_back(last_frame + static_cast<std::size_t>(k));
    }
    out.stacked.jacobian.conservativeResize(row, Eigen::NoChange);
    out.stacked.residual.conservativeResize(row);
    return out;
}

Eigen::MatrixXd covariance_by_frames(const WhitenedReadings& readings,
                                     const std::vector<bool>& is_held) {
    const Eigen::MatrixXd& jacobian = readings.stacked.jacobian;
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(jacobian.cols(), jacobian.cols());
    std::vector<Eigen::Index> free;
    for (Eigen::Index k = 0; k < jacobian.cols(); ++k)
        if (!is_held[static_cast<std::size_t>(k)] && jacobian.col(k).squaredNorm() > 0.0)
            free.push_back(k);
    if (free.empty())
        return covariance;
    std::map<std::size_t, Eigen::VectorXd> gradients;
    const auto count = static_cast<Eigen::Index>(free.size());
    for (Eigen::Index i = 0; i < jacobian.rows(); ++i) {
        Eigen::VectorXd& sum = gradients
                                   .try_emplace(readings.frames[static_cast<std::size_t>(i)],
                                                Eigen::VectorXd::Zero(count))
                                   .first->second;
        sum += jacobian(i, free).transpose() * readings.stacked.residual(i);
    }
    Eigen::MatrixXd meat = Eigen::MatrixXd::Zero(count, count);
    for (const auto& [frame, gradient] : gradients)
        meat += gradient * gradient.transpose();
    const auto frames = static_cast<double>(gradients.size());
    meat *= frames / std::max(frames - static_cast<double>(count), 1.0);

    const Eigen::MatrixXd columns = jacobian(Eigen::all, free);
    const auto told = fit::information_directions(columns.transpose() * columns);
    Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(count, count);
    for (Eigen::Index k = 0; k < count; ++k)
        if (told.is_known(k))
            inverse +=
                told.directions.col(k) * told.directions.col(k).transpose() / told.information(k);
    const auto unscaled = told.scale.cwiseInverse().asDiagonal();
    inverse = unscaled * inverse * unscaled;
    covariance(free, free) = inverse * meat * inverse;
    return covariance;
}

namespace {

constexpr int most_steps = 25;
constexpr int most_halvings = 5;
/// A step below this share of every standard error is the end.
constexpr double small_step = 0.02;

/// The model at one point, and what its misses look like there.
struct Point {
    fit::StartModels models;
    StackedReadings stacked;
    CorrelatedNoise noise;
};

class Estimation {
  public:
    Estimation(const fit::Fit& fit, std::span<const measure::Measurement> recordings,
               const fit::FitOptions& options)
        : fit_(fit), recordings_(recordings), options_(options) {
        for (const fit::RecordingFit& part : fit.parts)
            point_.models.push_back(part.model);
        layout_ = fit::joint_layout(point_.models, recordings, fit::belongs_to_recording);
        for (const fit::FittedParameter& parameter : fit.parameters)
            is_held_.push_back(parameter.is_at_bound);
        point_.stacked = stacked_readings(fit, recordings);
        list_sequences();
        point_.noise = correlated_noise(point_.stacked.residual, sequences_);
    }

    [[nodiscard]] bool is_correlated() const {
        return std::ranges::any_of(point_.noise.correlation,
                                   [](double correlation) { return correlation > 0.0; });
    }

    void solve() {
        for (int step = 0; step < most_steps; ++step)
            if (!improve())
                return;
    }

    [[nodiscard]] CorrelatedEstimate result() const {
        CorrelatedEstimate out;
        out.parameters = fit_.parameters;
        const Eigen::MatrixXd covariance =
            covariance_by_frames(whitened(point_.stacked, sequences_, point_.noise), is_held_);
        for (std::size_t k = 0; k < out.parameters.size(); ++k) {
            const auto place = static_cast<Eigen::Index>(k);
            out.parameters[k].value = value_of(layout_.owners[k]);
            if (const double variance = covariance(place, place); variance > 0.0)
                out.parameters[k].standard_error = std::sqrt(variance);
        }
        std::size_t sequence = 0;
        for (const fit::RecordingFit& part : fit_.parts) {
            std::vector<double>& rows = out.correlation.emplace_back();
            for (std::size_t j = 0; j < part.prediction.rows; ++j)
                rows.push_back(point_.noise.correlation[sequence++]);
        }
        return out;
    }

  private:
    /// Only what was measured after the release: before it the stem is held, and nothing is missed.
    void list_sequences() {
        std::size_t frame = 0;
        Eigen::Index begin = 0;
        for (const fit::RecordingFit& part : fit_.parts) {
            const std::size_t rows = part.prediction.rows;
            for (std::size_t j = 0; j < rows; ++j) {
                ReadingSequence& sequence = sequences_.emplace_back();
                sequence.first_frame = frame;
                for (std::size_t i = 0; i < part.times.size(); ++i) {
                    const std::size_t place = i * rows + j;
                    const bool is_seen = part.times[i] >= 0.0 && !std::isnan(part.residuals[place]);
                    sequence.readings.push_back(is_seen ? begin + static_cast<Eigen::Index>(place)
                                                        : Eigen::Index{-1});
                }
            }
            frame += part.times.size();
            begin += static_cast<Eigen::Index>(part.residuals.size());
        }
    }

    /// One step of Gauss and Newton with the noise as it is here, shortened until it helps.
    [[nodiscard]] bool improve() {
        // Cochrane and Orcutt alternate between the numbers and the correlation: whitening with ρ
        // of the present residuals turns the step into ordinary least squares. The likelihood with
        // the new ρ decides whether the step helped, because ρ and the numbers can trade with each
        // other.
        const WhitenedReadings readings = whitened(point_.stacked, sequences_, point_.noise);
        const Eigen::VectorXd change = solve_linear(readings.stacked, is_held_).change;
        const Eigen::MatrixXd covariance = covariance_by_frames(readings, is_held_);
        const Eigen::VectorXd errors = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
        if ((change.cwiseAbs() - small_step * errors).maxCoeff() <= 0.0)
            return false;
        double share = 1.0;
        for (int halving = 0; halving <= most_halvings; ++halving, share *= 0.5) {
            Point trial{moved(point_.models, layout_, share * change), {}, {}};
            try {
                trial.stacked =
                    stacked_readings(trial.models, recordings_, fit_, options_.heartbeat);
            } catch (const core::NumericalError&) {
                continue; // too far
            }
            trial.noise = correlated_noise(trial.stacked.residual, sequences_);
            if (trial.noise.cost < point_.noise.cost) {
                point_ = std::move(trial);
                return true;
            }
        }
        return false;
    }

    [[nodiscard]] double value_of(const fit::JointLayout::Owner& owner) const {
        return point_.models[owner.model].value(owner.parameter);
    }

    const fit::Fit& fit_;
    std::span<const measure::Measurement> recordings_;
    const fit::FitOptions& options_;
    fit::JointLayout layout_;
    std::vector<bool> is_held_;
    std::vector<ReadingSequence> sequences_;
    Point point_;
};

} // namespace

std::optional<CorrelatedEstimate>
correlated_estimate(const fit::Fit& fit, std::span<const measure::Measurement> recordings,
                    const fit::FitOptions& options) {
    Estimation estimation(fit, recordings, options);
    if (!estimation.is_correlated())
        return std::nullopt;
    estimation.solve();
    return estimation.result();
}

} // namespace culm::diagnose
