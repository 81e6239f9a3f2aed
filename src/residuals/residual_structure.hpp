// SPDX-License-Identifier: BSD-3-Clause
// Components of the residuals of a fitted chain: wrong amplitude, wrong phase, wrong rest of the
// swing, or another shape.
#pragma once

#include "fit/fit.hpp"
#include "residuals/swing.hpp"

#include <array>
#include <map>
#include <string>

namespace culm::residuals {

/// Errors of the swing in one third of the time after the release.
struct SwingError {
    double amplitude = 0.0; ///< measured over modelled amplitude, less 1
    double lag = 0.0;  ///< of the measured swing behind the modelled one, rad of the first mode
    double rest = 0.0; ///< measured less modelled position of rest, m
    double amplitude_error = 0.0; ///< standard errors, from the noise
    double lag_error = 0.0;
    double rest_error = 0.0;
    /// Amplitudes of both swings (√2 times their root mean square, less the noise's) over the noise
    /// of the swing. A swing that has decayed has no phase.
    double measured_over_noise = 0.0;
    double modelled_over_noise = 0.0;
};

template <class To>
void describe(To& to, const SwingError& error) {
    to("amplitude", error.amplitude);
    to("amplitude_stderr", error.amplitude_error);
    to("lag_rad", error.lag);
    to("lag_stderr_rad", error.lag_error);
    to("rest_mm", error.rest);
    to("rest_stderr_mm", error.rest_error);
    to("measured_over_noise", error.measured_over_noise);
    to("modelled_over_noise", error.modelled_over_noise);
}

struct ResidualStructure {
    std::array<SwingError, 3> thirds;
    /// Shares of the residuals' power above the noise's: the parts that a wrong amplitude, phase
    /// and rest of the swing explain, cycle by cycle; the remainder in the swing's shape; and the
    /// part in other shapes over the heights. Their sum is 1, or all are 0 if no power remains.
    double amplitude_share = 0.0;
    double phase_share = 0.0;
    double rest_share = 0.0;
    double other_motion_share = 0.0;
    double other_shape_share = 0.0;
    double excess_over_noise = 0.0; ///< power of the residuals over the noise's, less 1
};

/// Errors in the thirds of the time: their growth, decay or change of sign indicates the effect.
template <class To>
void describe(To& to, const ResidualStructure& found) {
    to("thirds", found.thirds);
    to("shares", [&] {
        return std::map<std::string, double>{{"amplitude", found.amplitude_share},
                                             {"phase", found.phase_share},
                                             {"rest", found.rest_share},
                                             {"other_motion", found.other_motion_share},
                                             {"other_shape", found.other_shape_share}};
    });
}

/// The residual of the swing in windows of two cycles is a sum of the modelled swing (amplitude),
/// its speed (phase) and a constant (rest), by least squares.
[[nodiscard]] ResidualStructure residual_structure(const fit::RecordingFit& fit,
                                                   const Swing& swing);

} // namespace culm::residuals
