// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/correlated_noise.hpp"

#include "fit/solve/information.hpp"

#include <algorithm>
#include <cmath>
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
    out.stacked.names = stacked.names;
    out.stacked.jacobian.resize(stacked.jacobian.rows(), stacked.jacobian.cols());
    out.stacked.residual.resize(stacked.residual.size());
    Eigen::Index row = 0;
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

} // namespace culm::diagnose
