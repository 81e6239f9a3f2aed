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

template <class Wire>
void fields(Wire& wire, NoiseModel& noise) {
    wire(noise.by_row, noise.source, noise.correlation, noise.common_share, noise.time_uncertainty,
         noise.relative);
}

/// Errors of the readings in addition to their noise, as far as a model of the stem determines them
/// (fit/solve/reading_errors.hpp): linear in numbers of mean 0 and standard deviation 1.
struct ReadingErrors {
    struct Term {
        std::string name;             ///< "length of S07"; terms of the same name are one number
        std::vector<double> readings; ///< (times, heights), m; empty: none
        double log_modulus = 0.0;     ///< change of ln Y of the chain, whose phases follow it
        double log_damping = 0.0;     ///< likewise of ln β
        bool is_of_row = false;       ///< each row has such a term
        /// No stated input, but part of every model: the error of a sensor, the start of a motion
        /// whose release was not recorded.
        bool is_in_every_model = false;
        /// An error of the model, whose columns its fit determines (solve/second_mode_errors.hpp).
        bool is_of_model = false;
    };
    std::vector<double> times; ///< s, of the readings
    Term known;                ///< the known part of the errors; without a name
    std::vector<Term> terms;
};

template <class Wire>
void fields(Wire& wire, ReadingErrors::Term& term) {
    wire(term.name, term.readings, term.log_modulus, term.log_damping, term.is_of_row,
         term.is_in_every_model, term.is_of_model);
}
template <class Wire>
void fields(Wire& wire, ReadingErrors& errors) {
    wire(errors.times, errors.known, errors.terms);
}

/// A fit weighs the readings by the noise and adds the errors to its prediction.
struct ObservedRecording : measure::Measurement {
    std::shared_ptr<const NoiseModel> noise_model; ///< null: the readings are independent
    std::shared_ptr<const ReadingErrors> errors;   ///< null: not determined

    ObservedRecording() = default;
    explicit ObservedRecording(measure::Measurement measurement)
        : measure::Measurement(std::move(measurement)) {}
};

/// The measurements before any fit.
[[nodiscard]] inline std::vector<ObservedRecording>
observed(std::span<const measure::Measurement> measurements) {
    std::vector<ObservedRecording> out;
    for (const measure::Measurement& measurement : measurements)
        out.emplace_back(measurement);
    return out;
}

} // namespace culm::fit
