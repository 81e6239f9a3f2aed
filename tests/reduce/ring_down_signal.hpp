// SPDX-License-Identifier: BSD-3-Clause
// Synthetic histories with known parameters for the tests of the fit of Eq. 1.
#pragma once

#include <cmath>
#include <cstddef>
#include <numbers>
#include <random>
#include <vector>

namespace culm::reduce::testing {

/// y = scale (exp(b1 t) cos(2π b2 t) + second_mode exp(b1 t) cos(2π 6.27 b2 t)) + noise; 6.27 is
/// the ratio of a cantilever's second frequency to its first.
struct RingDownSignal {
    double frequency = 60.0; // Hz
    double decay_per_cycle = -0.3;
    double window = 0.1;      // s
    double interval = 5e-5;   // s
    double scale = 0.015;     // m; negative: released from the other side
    double noise = 0.0;       // standard deviation over |scale|
    double second_mode = 0.0; // amplitude over the first one's
};

struct History {
    std::vector<double> times;
    std::vector<double> deflections;
};

inline History make_history(const RingDownSignal& signal, std::mt19937_64& random) {
    std::normal_distribution<double> normal(0.0, 1.0);
    const auto count = static_cast<std::size_t>(signal.window / signal.interval + 1e-9) + 1;
    History history;
    for (std::size_t k = 0; k < count; ++k) {
        const double t = static_cast<double>(k) * signal.interval;
        const double phase = 2.0 * std::numbers::pi * signal.frequency * t;
        const double envelope = std::exp(signal.decay_per_cycle * signal.frequency * t);
        const double motion =
            envelope * (std::cos(phase) + signal.second_mode * std::cos(6.27 * phase));
        const double noise = signal.noise > 0.0 ? signal.noise * normal(random) : 0.0;
        history.times.push_back(t);
        history.deflections.push_back(signal.scale * (motion + noise));
    }
    return history;
}

inline History make_history(const RingDownSignal& signal) {
    std::mt19937_64 random(1);
    return make_history(signal, random);
}

} // namespace culm::reduce::testing
