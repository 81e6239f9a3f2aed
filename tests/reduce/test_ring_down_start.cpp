// SPDX-License-Identifier: BSD-3-Clause
// The scan that provides starting values for the fit of Eq. 1.
#include "core/order_statistics.hpp"
#include "reduce/ring_down/ring_down_model.hpp"
#include "ring_down_signal.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace culm::reduce {
namespace {

using testing::History;
using testing::make_history;
using testing::RingDownSignal;

constexpr double allowed_decay = 2.0 * std::numbers::pi;

RingDownSamples normalised(const RingDownSignal& signal) {
    const History history = make_history(signal);
    RingDownSamples samples{history.times, history.deflections};
    for (double& value : samples.values)
        value /= signal.scale;
    return samples;
}

TEST(RingDownStart, TheFirstStartIsNextToTheTruth) {
    for (const double frequency : {20.0, 64.6, 113.1, 400.0}) {
        for (const double decay : {-0.01, -0.1, -0.46, -1.5}) {
            const RingDownSignal signal{frequency, decay};
            const auto starts = ring_down_starts(normalised(signal), allowed_decay);
            ASSERT_FALSE(starts.empty());
            const double rate = decay * frequency;
            // Half a step of the scan, 1/(8 duration); the envelope of a damped motion is shorter
            // than the record and widens the peak by a share of its rate.
            EXPECT_NEAR(starts[0].frequency, frequency, 1.25 + 0.1 * std::abs(rate));
            // Trial rates are 0 and 2^k/duration; the nearest lies within a factor of two, or
            // within one over the duration (10 1/s) of a slower decay.
            EXPECT_LE(std::abs(starts[0].decay_rate - rate), std::max(10.0, std::abs(rate)));
            EXPECT_LE(std::abs(rate), std::max(10.0, 2.0 * std::abs(starts[0].decay_rate)));
            EXPECT_NEAR(starts[0].amplitude, 1.0, 0.5); // of the right size
        }
    }
}

TEST(RingDownStart, TwoTonesOfOneStrengthAreBothTried) {
    RingDownSignal signal{60.0, -0.05};
    signal.second_mode = 0.95;
    const auto starts = ring_down_starts(normalised(signal), allowed_decay);
    ASSERT_GE(starts.size(), 2U);
    // Their order depends on the distance of each from a grid point; one step is 2.5 Hz.
    const auto [low, high] = std::minmax(starts[0].frequency, starts[1].frequency);
    EXPECT_NEAR(low, 60.0, 2.5);
    EXPECT_NEAR(high, 6.27 * 60.0, 2.5);
}

TEST(RingDownStart, StartsAreDistinctAndFewAndWithinTheAllowedDecay) {
    RingDownSignal signal{64.6, -0.46, 0.3, 1.0 / 960.0};
    signal.noise = 0.8; // nearly nothing but noise: many peaks of similar height
    const auto starts = ring_down_starts(normalised(signal), 0.6);
    EXPECT_GE(starts.size(), 1U);
    EXPECT_LE(starts.size(), 4U);
    for (std::size_t i = 0; i < starts.size(); ++i) {
        EXPECT_LE(-starts[i].decay_rate, 0.6 * starts[i].frequency);
        EXPECT_LE(starts[i].frequency, 480.0 + 1e-9); // half the sampling rate
        for (std::size_t j = 0; j < i; ++j)
            EXPECT_NE(starts[i].frequency, starts[j].frequency);
    }
}

TEST(RingDownStart, TheMedianIntervalIgnoresGaps) {
    EXPECT_DOUBLE_EQ(core::median_interval(std::vector<double>{0.0, 1.0, 2.0, 9.0, 10.0, 11.0}),
                     1.0);
}

} // namespace
} // namespace culm::reduce
