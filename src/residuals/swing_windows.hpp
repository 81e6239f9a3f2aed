// SPDX-License-Identifier: BSD-3-Clause
// Frequency, decay and position of rest of the swing as its amplitude falls, measured and modelled.
#pragma once

#include "reduce/ring_down/ring_down_analysis.hpp"
#include "residuals/swing.hpp"

#include <optional>
#include <vector>

namespace culm::residuals {

/// Eq. 1 with phase and offset, fitted to some cycles of the swing.
struct WindowFit {
    double amplitude = 0.0;           ///< in the middle of the window, m
    reduce::Estimate frequency;       ///< Hz
    reduce::Estimate decay_per_cycle; ///< b1/b2
    reduce::Estimate rest;            ///< position of rest, m
};

struct SwingWindow {
    double begin = 0.0; ///< s
    double end = 0.0;
    std::optional<WindowFit> measured; ///< empty: Eq. 1 could not be fitted
    std::optional<WindowFit> modelled;
};

/// Windows of five cycles, each beginning in the middle of the one before; both sides are fitted in
/// the same way, so that what a window does to Eq. 1 (a second mode, a changing frequency) cancels
/// in their difference. Windows in which the measured amplitude is below three times the noise are
/// left out.
[[nodiscard]] std::vector<SwingWindow> swing_windows(const Swing& swing);

/// Amplitude of the measured swing in every frame, from the windows, m; NaN before the first and
/// after the last of them.
[[nodiscard]] std::vector<double> envelope(const Swing& swing,
                                           const std::vector<SwingWindow>& windows);

} // namespace culm::residuals
