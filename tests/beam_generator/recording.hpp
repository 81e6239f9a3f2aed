// SPDX-License-Identifier: BSD-3-Clause
// A made-up recording of a beam that is pulled aside and let go.
#pragma once

#include "beam_generator/hidden_effect.hpp"
#include "measure/folder/measurement.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace culm::beam {

/// Errors of the table of deflections.
struct ReadingErrors {
    double noise = 0.0;          ///< standard deviation, m
    double correlation = 0.0;    ///< of the noise of one row from frame to frame: AR(1)
    double missing_share = 0.0;  ///< of the readings, at random positions
    double outlier_share = 0.0;  ///< likewise
    double outlier_size = 0.0;   ///< standard deviation of what outliers add, m
    double quantum = 0.0;        ///< readings are multiples of it, m; 0: not rounded
    double clock_error = 0.0;    ///< time from time 0 to the release, s
    double length_error = 0.0;   ///< share by which the stated length is too large
    bool is_noise_stated = true; ///< in the measurement
};

/// All quantities that determine a recording.
struct RecordingSpec {
    std::string id = "beam";
    BeamStem stem;
    double tip_deflection = 20e-3; ///< m
    std::vector<HiddenEffect> effects;
    LawErrors law_errors;
    std::vector<double> heights; ///< of the image rows, m
    double frames_per_second = 1000.0;
    int frames_before = 6; ///< the release
    double duration = 0.4; ///< after it, s
    /// Stated time of the hold before the release, s; relaxation has its own parameter.
    double hold_time = 10.0;
    measure::GravityDirection gravity_direction = measure::GravityDirection::None;
    ReadingErrors errors;
    std::uint64_t seed = 1; ///< of the errors
};

/// `rows` heights, evenly from 8 % to 88 % of the length: rows that a strongly bent stem reaches.
[[nodiscard]] std::vector<double> even_heights(double length, int rows);

/// Readings of the camera without reading errors: (times, heights) row-major, m; NaN where the stem
/// does not reach the row. `times` start at the release; before it the stem is held, on a support
/// that may vibrate. Throws core::InputError and core::NumericalError.
[[nodiscard]] std::vector<double> true_readings(const RecordingSpec& spec,
                                                const std::vector<double>& times);

/// A point of the stem's axis, m.
struct AxisPoint {
    double height = 0.0;
    double deflection = 0.0;
};

/// The axis at each of `times` (not empty), at `points` >= 2 equal intervals of its arc from the
/// clamp to the tip. A vibrating support and the camera's faults are omitted. Throws
/// core::InputError and core::NumericalError.
[[nodiscard]] std::vector<std::vector<AxisPoint>>
axis_positions(const RecordingSpec& spec, const std::vector<double>& times, int points);

/// The recording as a measurement folder contains it. It is the same on every machine and rank for
/// equal specs, up to rounding.
[[nodiscard]] measure::Measurement record(const RecordingSpec& spec);

} // namespace culm::beam
