// SPDX-License-Identifier: BSD-3-Clause
// The observation operator: what a measurement would have read of a simulated motion.
#pragma once

#include "measure/curve_reading.hpp"
#include "measure/measurement.hpp"

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace culm::measure {

/// Where and how a chain is read.
struct ObservedPlaces {
    Reading reading = Reading::Row;
    std::vector<double> heights; ///< m
    int dimensions = 2;          ///< of the positions
    double bond_length = 0.0;    ///< m; needed for marks
};

/// One frame: a reading per height. `positions` as in read_row.
[[nodiscard]] std::vector<CurveReading> read_frame(const ObservedPlaces& places,
                                                   std::span<const double> positions);

/// How a value at one time follows from samples: a cubic through four of them in time. Its error is
/// at most 3/128 Δt⁴ |y''''| (1/24 in the first and last interval), Δt the distance of the samples:
/// 5e-8 of the amplitude for 60 Hz and Δt = 0.1 ms.
struct TimeStencil {
    std::size_t first = 0;
    std::size_t samples = 0; ///< 0: the time lies after the last sample
    std::array<double, 4> weights{};
    std::array<double, 4> rates{}; ///< weights of the derivative by time, 1/s

    /// Value and derivative by time (per s) of column j of samples (times, columns) row-major; NaN
    /// if there are no samples.
    [[nodiscard]] double value(std::span<const double> table, std::size_t columns,
                               std::size_t j) const;
    [[nodiscard]] double rate(std::span<const double> table, std::size_t columns,
                              std::size_t j) const;
};

/// `sample_times` ascend strictly. Before the first sample the stem is held, so the value is that
/// of the first sample and its rate 0; the cubic never reaches across the first sample, at which
/// the acceleration jumps. An excess over the last sample of 1e-9 of the record counts as rounding.
[[nodiscard]] TimeStencil time_stencil(std::span<const double> sample_times, double time);

/// Readings at other times: a table (times, columns) row-major from samples (sample_times,
/// columns). `rates` (if not null) gets the derivative by time, of the same shape: minus the
/// derivative by a common shift of the release.
[[nodiscard]] std::vector<double> resampled_in_time(std::span<const double> sample_times,
                                                    std::span<const double> table,
                                                    std::span<const double> times,
                                                    std::vector<double>* rates = nullptr);

} // namespace culm::measure
