// SPDX-License-Identifier: BSD-3-Clause
// A made-up recording of a beam that is pulled aside and let go.
#pragma once

#include "beam_generator/hidden_effect.hpp"
#include "measure/folder/measurement.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace culm::beam {

/// What stands between the stem and the table of deflections.
struct ReadingErrors {
    double noise = 0.0;          ///< standard deviation, m
    double correlation = 0.0;    ///< of the noise of one row from frame to frame: AR(1)
    double missing_share = 0.0;  ///< of the readings, at random places
    double outlier_share = 0.0;  ///< likewise
    double outlier_size = 0.0;   ///< standard deviation of what outliers add, m
    double quantum = 0.0;        ///< readings are multiples of it, m; 0: not rounded
    double clock_error = 0.0;    ///< the release happens so much after time 0, s
    double length_error = 0.0;   ///< share by which the stated length is too large
    bool is_noise_stated = true; ///< in the measurement
};

/// All that a recording follows from.
struct RecordingSpec {
    std::string id = "beam";
    BeamStem stem;
    double tip_deflection = 20e-3; ///< m
    std::vector<HiddenEffect> effects;
    std::vector<double> heights; ///< of the image rows, m
    double frames_per_second = 1000.0;
    int frames_before = 6; ///< the release
    double duration = 0.4; ///< after it, s
    /// For which the stem is said to have been held, s; relaxation has a parameter of its own.
    double hold_time = 10.0;
    measure::GravityDirection gravity_direction = measure::GravityDirection::None;
    ReadingErrors errors;
    std::uint64_t seed = 1; ///< of the errors
};

/// `rows` heights, evenly from 8 % to 88 % of the length: what even a strong pull leaves in sight.
[[nodiscard]] std::vector<double> even_heights(double length, int rows);

/// What the camera would see without reading errors: (times, heights) row-major, m; NaN where the
/// stem does not reach the row. `times` from the release; before it the stem is held, on a support
/// that may vibrate. Throws core::InputError and core::NumericalError.
[[nodiscard]] std::vector<double> true_readings(const RecordingSpec& spec,
                                                const std::vector<double>& times);

/// The recording as a measurement folder would hold it. The same on every machine and rank for
/// equal specs, up to rounding.
[[nodiscard]] measure::Measurement record(const RecordingSpec& spec);

} // namespace culm::beam
