// SPDX-License-Identifier: BSD-3-Clause
#include "fit/chain/first_motion.hpp"

#include "core/error.hpp"
#include "core/order_statistics.hpp"
#include "reduce/population_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <fmt/core.h>

namespace culm::fit {
namespace {

/// Eq. 1 at the height of the largest swing where it can be fitted, or of the sensor that it
/// explains best; `reason` if there is none.
std::optional<RowRingDown> largest_ring_down(const measure::Measurement& measurement,
                                             bool has_offset, std::string& reason) {
    std::optional<RowRingDown> best;
    reduce::RingDownOptions options{.is_measured = true};
    options.has_phase = true;
    options.has_offset = has_offset;
    const bool has_sensors = !measurement.sensors.empty();
    const auto merit = [&](const reduce::RingDownFit& fit) {
        return has_sensors ? fit.r_squared : fit.largest_deflection * fit.r_squared;
    };
    // The upper half of the heights is enough: the lower ones swing less.
    for (std::size_t j = has_sensors ? 0 : measurement.heights.size() / 2;
         j < measurement.heights.size(); ++j) {
        try {
            reduce::RingDownFit fit =
                reduce::fit_ring_down(measurement.times, measurement.history(j), options);
            if (!best || merit(fit) > merit(best->fit))
                best = {j, std::move(fit)};
        } catch (const core::NumericalError& error) {
            reason = error.what();
        }
    }
    return best;
}

/// Deflection of a cantilever under a force at its tip over that of the tip: x²(3 − x)/2.
double tip_force_shape(const measure::Measurement& measurement, std::size_t row) {
    const double x = std::min(measurement.heights[row] / measurement.stem.length, 1.0);
    return 0.5 * x * x * (3.0 - x);
}

/// The reading of a row, as a complex amplitude, per deflection of the tip in a vibration of this
/// complex angular frequency and the shape of tip_force_shape().
std::complex<double> reading_per_deflection(const measure::Measurement& measurement,
                                            std::size_t row, std::complex<double> rate) {
    const double length = measurement.stem.length;
    if (!measurement.sensors.empty() &&
        measurement.sensors[row].quantity == measure::Quantity::Strain)
        return -3.0 * measurement.sensors[row].distance_from_axis *
               (1.0 - measurement.heights[row] / length) / (length * length);
    return std::pow(rate, measurement.time_derivatives_at(row)) * tip_force_shape(measurement, row);
}

} // namespace

double frame_period(const measure::Measurement& measurement) {
    if (measurement.frames_per_second)
        return 1.0 / *measurement.frames_per_second;
    return measurement.times.size() < 2 ? 0.0 : core::median_interval(measurement.times);
}

reduce::HeightHistories height_histories(const measure::Measurement& measurement) {
    reduce::HeightHistories out;
    out.times = measurement.times;
    for (std::size_t j = 0; j < measurement.heights.size(); ++j) {
        out.histories.push_back(measurement.history(j));
        double largest = 0.0;
        for (const double reading : out.histories.back())
            largest = std::max(largest, std::isnan(reading) ? 0.0 : std::abs(reading));
        out.weights.push_back(1.0 /
                              std::max(measurement.noise_at(j).value_or(1e-3 * largest), 1e-300));
    }
    return out;
}

std::complex<double> tip_motion(const measure::Measurement& measurement, const RowRingDown& found) {
    const reduce::RingDownFit& fit = found.fit;
    return std::polar(fit.amplitude.value, fit.phase.value) /
           reading_per_deflection(
               measurement, found.row,
               {fit.decay_rate.value, 2.0 * std::numbers::pi * fit.frequency.value});
}

RowRingDown measured_ring_down(const measure::Measurement& measurement) {
    std::string reason;
    std::optional<RowRingDown> best = largest_ring_down(
        measurement,
        measurement.release == measure::ReleaseKind::HeldStraight || !measurement.sensors.empty(),
        reason);
    // A stem that is curved at rest swings about its own curve, and Eq. 1 about zero finds no
    // vibration.
    if (!best)
        best = largest_ring_down(measurement, true, reason);
    if (!best)
        throw core::NumericalError(
            core::FailureKind::FitFailed,
            fmt::format("{}: Eq. 1 cannot be fitted at any height, so there is nothing to start "
                        "from: {}",
                        measurement.stem.id, reason));
    return *std::move(best);
}

double released_deflection(const measure::Measurement& measurement) {
    std::vector<double> deflections;
    const auto first = std::ranges::lower_bound(measurement.times, 0.0);
    const auto release = static_cast<std::size_t>(first - measurement.times.begin());
    for (std::size_t i = 0; i < std::min(release + 1, measurement.times.size()); ++i)
        for (std::size_t j = 0; j < measurement.heights.size(); ++j) {
            const double reading = measurement.deflection(i, j);
            // Lower readings are divided by a small number, which amplifies their noise.
            if (measurement.heights[j] > 0.5 * measurement.stem.length && !std::isnan(reading))
                deflections.push_back(reading / tip_force_shape(measurement, j));
        }
    std::ranges::sort(deflections);
    if (!deflections.empty() && reduce::quantile(deflections, 0.5) != 0.0)
        return reduce::quantile(deflections, 0.5);
    double largest = 0.0;
    for (const double reading : measurement.deflections)
        if (std::abs(reading) > std::abs(largest)) // false for NaN
            largest = reading;
    return largest;
}

void release_before(const measure::Measurement& measurement, const RowRingDown& found,
                    StemModel& model) {
    const reduce::RingDownFit& ring_down = found.fit;
    const std::complex<double> motion = tip_motion(measurement, found);
    const double period = 1.0 / ring_down.frequency.value;
    // cos(2π b2 t + φ) is at a turning point where 2π b2 t + φ = k π.
    double since = std::arg(motion) / std::numbers::pi * 0.5 * period;
    int half_periods = 0;
    while (since > 0.75 * period) {
        since -= 0.5 * period;
        ++half_periods;
    }
    while (since <= 0.25 * period) {
        since += 0.5 * period;
        ++half_periods;
    }
    const double side = half_periods % 2 == 0 ? 1.0 : -1.0;
    const double decay = std::exp(-ring_down.decay_rate.value * since);
    model.spec.tip_deflection = side * std::abs(motion) * decay;
    model.expected_release = -since;
    model.release_time = -since;
    model.release_time_bound = 0.25 * period;
}

} // namespace culm::fit
