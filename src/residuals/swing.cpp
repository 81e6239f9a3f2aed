// SPDX-License-Identifier: BSD-3-Clause
#include "residuals/swing.hpp"

#include "fit/chain/first_motion.hpp"
#include "physics/effects/stem_scales.hpp"
#include "run/modes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

namespace culm::residuals {
namespace {

/// Products of two rows' readings over their noise, summed over the frames after the release.
Eigen::MatrixXd row_products(const fit::RecordingFit& fit, const std::vector<double>& readings) {
    const auto free = fit.times.end() - std::ranges::lower_bound(fit.times, 0.0);
    const Eigen::MatrixXd swinging = over_noise(fit, readings).bottomRows(free);
    return swinging.transpose() * swinging;
}

std::vector<double> strongest_shape(const fit::RecordingFit& fit,
                                    const measure::Measurement& measurement) {
    Eigen::MatrixXd products = row_products(fit, fit.prediction.readings);
    if (!(products.trace() > 0.0))
        products = row_products(fit, measurement.deflections);
    // The leading eigenvector of YᵀY: no other shape explains more of the motion (first principal
    // component, with readings in units of their noise).
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(products);
    const Eigen::VectorXd strongest = solver.eigenvectors().col(products.rows() - 1);
    std::vector<double> shape;
    double largest = 0.0;
    for (Eigen::Index j = 0; j < strongest.size(); ++j) {
        shape.push_back(strongest(j) * fit.noise[static_cast<std::size_t>(j)]);
        if (std::abs(shape.back()) > std::abs(largest))
            largest = shape.back();
    }
    for (double& entry : shape)
        entry /= largest == 0.0 ? 1.0 : largest;
    return shape;
}

/// Puts the readings of a row, (frames, rows), in the place of those of a history that were seen.
void replace_seen(std::span<const double> readings, std::size_t rows, std::size_t row,
                  std::vector<double>& history) {
    history.resize(readings.size() / rows);
    for (std::size_t i = 0; i < history.size(); ++i)
        if (!std::isnan(history[i]))
            history[i] = readings[i * rows + row];
}

} // namespace

Eigen::MatrixXd over_noise(const fit::RecordingFit& fit, const std::vector<double>& readings) {
    const Eigen::Map<const RowMajorMatrix> frames(readings.data(), std::ssize(fit.times),
                                                  std::ssize(fit.noise));
    const Eigen::Map<const Eigen::VectorXd> noise(fit.noise.data(), std::ssize(fit.noise));
    return frames.array().isNaN().select(0.0, frames) * noise.cwiseInverse().asDiagonal();
}

Swing swing_of(const fit::RecordingFit& fit, const measure::Measurement& measurement) {
    Swing swing;
    const std::vector<double> shape = strongest_shape(fit, measurement);
    const std::size_t rows = shape.size();
    swing.times = fit.times;
    for (std::size_t i = 0; i < fit.times.size(); ++i) {
        // q = Σ w s y/Σ w s² minimises Σ w (y − q s)², w = 1/σ², over the rows that were seen.
        double sum = 0.0;
        double norm = 0.0;
        for (std::size_t j = 0; j < rows; ++j) {
            if (std::isnan(fit.residuals[i * rows + j]))
                continue;
            const double precision = 1.0 / (fit.noise[j] * fit.noise[j]);
            sum += precision * shape[j] * measurement.deflections[i * rows + j];
            norm += precision * shape[j] * shape[j];
        }
        swing.measured.push_back(norm > 0.0 ? sum / norm
                                            : std::numeric_limits<double>::quiet_NaN());
    }
    // The variance of q in a frame without gaps is 1/Σ w s².
    double precision = 0.0;
    for (std::size_t j = 0; j < rows; ++j)
        precision += std::pow(shape[j] / fit.noise[j], 2);
    swing.noise = precision > 0.0 ? 1.0 / std::sqrt(precision) : 0.0;
    const auto modes = run::chain_modes(fit.model.spec, 1);
    swing.frequency =
        modes.empty() ? physics::first_frequency(fit.model.spec.stem) : modes.front().frequency;
    return swing;
}

reduce::BackboneInput backbone_input(const measure::Measurement& measurement,
                                     std::span<const double> readings) {
    reduce::BackboneInput input;
    input.heights = measurement.heights;
    input.histories = fit::height_histories(measurement);
    const std::size_t rows = measurement.heights.size();
    if (!readings.empty())
        input.histories.times.resize(readings.size() / rows);
    for (std::size_t j = 0; j < rows; ++j) {
        if (!readings.empty())
            replace_seen(readings, rows, j, input.histories.histories[j]);
        input.derivatives.push_back(measurement.time_derivatives_at(j));
        input.has_deflections =
            input.has_deflections && (measurement.sensors.empty() ||
                                      measurement.sensors[j].quantity != measure::Quantity::Strain);
    }
    return input;
}

BackbonesOfBoth backbones_of_both(const fit::RecordingFit& fit,
                                  const measure::Measurement& measurement) {
    reduce::BackboneInput input = backbone_input(measurement);
    input.last = fit.times.back();
    BackbonesOfBoth both{reduce::backbones(input),
                         reduce::backbones(backbone_input(measurement, fit.prediction.readings))};
    for (std::size_t k = 0; k < std::min(both.measured.size(), both.modelled.size()); ++k) {
        const auto& measured = both.measured[k].points;
        if (!measured.empty())
            std::erase_if(both.modelled[k].points, [&](const reduce::BackbonePoint& point) {
                return point.amplitude < 0.8 * measured.back().amplitude;
            });
    }
    return both;
}

RingDownsOfBoth ring_downs_of_both(const fit::RecordingFit& fit,
                                   const measure::Measurement& measurement) {
    // Eq. 1 assumes a release from rest at time 0; measurement and model get a free phase alike.
    reduce::RingDownOptions options{.is_measured = true};
    options.window = fit.times.back();
    options.has_phase = true;
    options.has_offset = measurement.release == measure::ReleaseKind::HeldStraight ||
                         !fit.model.spec.effects.empty();
    measure::Measurement modelled = measurement;
    modelled.times.resize(fit.times.size());
    replace_seen(fit.prediction.readings, 1, 0, modelled.deflections);
    return {fit_stem(measurement, options), fit_stem(modelled, options)};
}

} // namespace culm::residuals
