// SPDX-License-Identifier: BSD-3-Clause
// The strongest shape of the motion over the heights, its coordinate in measurement and model, and
// frequency, decay and position of rest as its amplitude falls; and Eq. 1 at every height.
#pragma once

#include "fit/fit.hpp"
#include "measure/folder/measurement.hpp"
#include "reduce/backbone/backbone.hpp"
#include "reduce/ring_down/stem_ring_downs.hpp"

#include <optional>
#include <vector>

namespace culm::residuals {

/// The heights move together in the shape with most of the motion (the first mode if one mode
/// dominates, the common shape of two close modes). Coordinates are those of the row where the
/// shape is largest, m.
struct Swing {
    std::vector<double> shape;          ///< (rows), 1 at the largest
    std::vector<double> times;          ///< (frames), s
    std::vector<double> measured;       ///< (frames), m; NaN where no row was seen
    std::vector<double> modelled;       ///< (frames), m, from the rows that were seen
    std::vector<double> modelled_speed; ///< (frames), m/s
    double noise = 0.0;                 ///< of a measured coordinate with all rows, m
    double noise_correlation = 0.0;     ///< of that noise from frame to frame
    double frequency = 0.0;             ///< of the fitted chain's first mode, Hz
};

/// The shape is the first right singular vector of the predicted readings after the release (of the
/// measured ones, if the model does not move), weighted by the noise.
[[nodiscard]] Swing swing_of(const fit::RecordingFit& fit, const measure::Measurement& measurement);

/// Eq. 1 with phase and offset, fitted to some cycles of the swing.
struct WindowFit {
    double amplitude = 0.0;           ///< in the middle of the window, m
    reduce::Estimate frequency;       ///< Hz
    reduce::Estimate decay_per_cycle; ///< b1/b2
    reduce::Estimate rest;            ///< position of rest, m
};

template <class To>
void describe(To& to, const WindowFit& found) {
    to("amplitude_mm", found.amplitude);
    to("frequency_hz", found.frequency);
    to("b1_per_cycle", found.decay_per_cycle);
    to("rest_mm", found.rest);
}

struct SwingWindow {
    double begin = 0.0; ///< s
    double end = 0.0;
    std::optional<WindowFit> measured; ///< empty: Eq. 1 could not be fitted
    std::optional<WindowFit> modelled;
};

/// Measured and modelled motion are fitted by Eq. 1 in the same windows, so that deviations from
/// Eq. 1 affect both alike.
template <class To>
void describe(To& to, const SwingWindow& window) {
    to("begin_s", window.begin);
    to("end_s", window.end);
    to("measured", window.measured);
    to("modelled", window.modelled);
}

/// Windows of five cycles, each beginning in the middle of the one before. Measurement and model
/// are fitted in the same way, so that the effect of a window on Eq. 1 (a second mode, a changing
/// frequency) cancels in their difference. Windows in which the measured amplitude is below three
/// times the noise are omitted.
[[nodiscard]] std::vector<SwingWindow> swing_windows(const Swing& swing);

/// The readings at every height, with their noise where it is known.
[[nodiscard]] reduce::StemHistories histories_of(const measure::Measurement& measurement);

/// The readings for a backbone; `readings` (times, heights) instead of the measured ones.
[[nodiscard]] reduce::BackboneInput backbone_input(const measure::Measurement& measurement,
                                                   std::span<const double> readings = {});

struct RingDownsOfBoth {
    reduce::StemRingDowns measured;
    reduce::StemRingDowns modelled; ///< at the same times and heights
};

/// Eq. 1 with a free phase, fitted in the same way to both, over the time of the fit.
[[nodiscard]] RingDownsOfBoth ring_downs_of_both(const fit::RecordingFit& fit,
                                                 const measure::Measurement& measurement);

} // namespace culm::residuals
