// SPDX-License-Identifier: BSD-3-Clause
#include "residuals/swing_windows.hpp"

#include "core/error.hpp"

#include <cmath>
#include <limits>

namespace culm::residuals {
namespace {

constexpr double cycles_of_window = 5.0;
constexpr std::size_t fewest_window_frames = 15; ///< for five numbers
constexpr double smallest_amplitude = 3.0;       ///< over the noise

std::optional<WindowFit> fit_window(const std::vector<double>& times,
                                    const std::vector<double>& values, double length) {
    reduce::RingDownAnalysisOptions options;
    options.has_phase = true;
    options.has_offset = true;
    try {
        const reduce::RingDownAnalysis found = reduce::analyse_ring_down(times, values, options);
        // A exp(b t) at the middle of the window, where its amplitude is known best.
        return WindowFit{std::abs(found.amplitude.value) *
                             std::exp(0.5 * length * found.decay_rate.value),
                         found.frequency, found.decay_per_cycle, found.offset};
    } catch (const core::NumericalError&) {
        return std::nullopt;
    }
}

} // namespace

std::vector<SwingWindow> swing_windows(const Swing& swing) {
    std::vector<SwingWindow> windows;
    const double length = cycles_of_window / swing.frequency;
    for (double begin = 0.0; begin + length <= swing.times.back() * (1.0 + 1e-9);
         begin += 0.5 * length) {
        std::vector<double> times;
        std::vector<double> measured;
        std::vector<double> modelled;
        for (std::size_t i = 0; i < swing.times.size(); ++i) {
            const double time = swing.times[i] - begin;
            if (time < 0.0 || time > length || std::isnan(swing.measured[i]))
                continue;
            times.push_back(time);
            measured.push_back(swing.measured[i]);
            modelled.push_back(swing.modelled[i]);
        }
        if (times.size() < fewest_window_frames)
            continue;
        SwingWindow window{begin, begin + length, fit_window(times, measured, length),
                           fit_window(times, modelled, length)};
        if (window.measured && window.measured->amplitude < smallest_amplitude * swing.noise)
            continue;
        windows.push_back(window);
    }
    return windows;
}

std::vector<double> envelope(const Swing& swing, const std::vector<SwingWindow>& windows) {
    std::vector<double> amplitudes(swing.times.size(), std::numeric_limits<double>::quiet_NaN());
    for (const SwingWindow& window : windows) {
        if (!window.measured)
            continue;
        const double middle = 0.5 * (window.begin + window.end);
        // Per second from per cycle: b1 f.
        const double rate =
            window.measured->decay_per_cycle.value * window.measured->frequency.value;
        for (std::size_t i = 0; i < swing.times.size(); ++i)
            if (swing.times[i] >= window.begin && swing.times[i] <= window.end)
                amplitudes[i] =
                    window.measured->amplitude * std::exp(rate * (swing.times[i] - middle));
    }
    return amplitudes;
}

} // namespace culm::residuals
