// SPDX-License-Identifier: BSD-3-Clause
// An error of the readings of a recording in addition to their noise: a change of the readings in
// proportion to a number of mean 0 and standard deviation 1.
#pragma once

#include <string>
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

} // namespace culm::fit
