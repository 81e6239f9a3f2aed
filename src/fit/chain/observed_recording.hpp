// SPDX-License-Identifier: BSD-3-Clause
// A recording with the errors of its readings, as far as fits have determined them.
#pragma once

#include "measure/folder/measurement.hpp"

#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace culm::fit {

enum class ErrorKind {
    StatedInput, ///< a measured quantity that the model takes as a number
    Division,    ///< of the stem into spheres
    Release,     ///< by hand: every mode starts with another amplitude and velocity
    Place,       ///< in the picture: lens, light
    Sensor,      ///< its offset and drift
    SecondMode,  ///< its frequency and loss in the model
    Modulus,     ///< Y and β of one of several recordings, as far as its stated inputs change them
    Damping,
};

/// Does each row have other terms?
[[nodiscard]] inline bool is_of_row(ErrorKind kind) {
    return kind == ErrorKind::Place || kind == ErrorKind::Sensor;
}

/// An error of the readings of a recording in addition to their noise: a change of the readings in
/// proportion to a number of mean 0 and standard deviation 1.
struct ErrorTerm {
    ErrorKind kind = ErrorKind::StatedInput;
    std::string id; ///< "length (0.156 m) of S07": terms of the same id are one number
    /// (times, heights), m: change by one standard uncertainty; empty: none.
    std::vector<double> readings;
    double log_modulus = 0.0; ///< change of ln Y of the recording's chain
    double log_damping = 0.0; ///< likewise of ln β

    /// Is it part of every fit? The other terms only enter the linear solution about a fit.
    [[nodiscard]] bool is_fitted() const {
        return kind == ErrorKind::Sensor || kind == ErrorKind::Modulus ||
               kind == ErrorKind::Damping;
    }
};

/// Noise of the readings while the stem moves.
struct NoiseModel {
    std::vector<double> by_row;    ///< standard deviation, m; empty: only residuals determine it
    std::string source;            ///< as text
    double correlation = 0.0;      ///< of a row's errors in two frames: first-order autoregression
    double common_share = 0.0;     ///< correlation of two rows in one frame
    double time_uncertainty = 0.0; ///< of a sensor's time stamps, s; included in `relative`
    /// Standard deviation of each reading over its row's noise, (times, rows); empty: 1.
    std::vector<double> relative;
};

/// Errors of the readings that are part of the prediction.
struct ReadingErrors {
    std::vector<double> times;    ///< s, of the readings
    std::vector<double> known;    ///< (times, heights), m: their known part; empty: none
    std::vector<ErrorTerm> terms; ///< that are fitted
};

/// A fit weighs the readings by the noise and adds the errors to its prediction.
struct ObservedRecording : measure::Measurement {
    std::shared_ptr<const NoiseModel> noise_model; ///< null: the readings are independent
    std::shared_ptr<const ReadingErrors> errors;   ///< null: none
    /// Terms that are the same for all models, but not fitted; null: not determined.
    std::shared_ptr<const std::vector<ErrorTerm>> terms;
    std::vector<std::string> missing_terms; ///< as RecordingFit::missing_terms

    ObservedRecording() = default;
    explicit ObservedRecording(measure::Measurement measurement)
        : measure::Measurement(std::move(measurement)) {}
};

/// The noise and the errors travel; every rank has the readings.
template <class Wire>
void fields(Wire& wire, ObservedRecording& recording) {
    wire(recording.noise_model, recording.errors, recording.terms, recording.missing_terms);
}

/// The measurements before any fit.
[[nodiscard]] inline std::vector<ObservedRecording>
observed(std::span<const measure::Measurement> measurements) {
    std::vector<ObservedRecording> out;
    for (const measure::Measurement& measurement : measurements)
        out.emplace_back(measurement);
    return out;
}

} // namespace culm::fit
