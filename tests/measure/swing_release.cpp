// SPDX-License-Identifier: BSD-3-Clause
// The release of generated recordings of a beam at 120 Hz to 50 kHz: let go by a string or by a
// hand that opens slowly, with a drift of the hand, with a pull in the record.
#include "measure/release/swing_release.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace culm::measure {
namespace {

constexpr double pi = std::numbers::pi;

/// Deflection over the held one of the tip of a beam, by five of its modes with Kelvin–Voigt
/// damping; 12/k⁴ is the share of a mode in the static deflection (series of Σ 12/k⁴ = 1).
double tip_motion(double cycles, double damping_ratio) {
    if (cycles <= 0.0)
        return 1.0;
    constexpr std::array<double, 5> roots{1.8751040687, 4.6940911330, 7.8547574382, 10.9955407349,
                                          14.1371683910};
    double sum = 0.0;
    double shares = 0.0;
    for (const double root : roots) {
        const double ratio = std::pow(root / roots[0], 2);
        const double zeta = std::min(damping_ratio * ratio, 0.9);
        const double angle = 2.0 * pi * ratio * cycles;
        const double damped = std::sqrt(1.0 - zeta * zeta);
        const double share = 12.0 / std::pow(root, 4);
        shares += share;
        sum += share * std::exp(-zeta * angle) *
               (std::cos(damped * angle) + zeta / damped * std::sin(damped * angle));
    }
    return sum / shares;
}

struct Recording {
    std::vector<double> times;
    std::vector<double> positions;
    double release = 0.0; ///< the hand begins to open
};

enum class LetGo { ByString, ByHand, AfterPull };

/// A swing of 10 mm about 5 mm, with noise.
Recording recorded(std::mt19937& generator, LetGo kind) {
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    const auto between = [&](double low, double high) {
        return low + (high - low) * uniform(generator);
    };
    const double rate = std::exp(between(std::log(120.0), std::log(50000.0)));
    const double frequency =
        std::max(rate / 1000.0, rate > 400.0 ? between(3.0, 36.0) : between(1.0, 8.0));
    const double period = 1.0 / frequency;
    const double damping_ratio = between(0.003, 0.05);
    const double opening = kind == LetGo::ByString ? 0.0 : between(0.0, 0.03) * period;
    const double pull_begin = kind == LetGo::AfterPull ? 0.5 * period : 0.0;
    Recording recording;
    recording.release = pull_begin + between(0.8, 5.0) * period;
    const double noise_size = std::pow(10.0, between(-3.0, -1.3)); // mm
    std::normal_distribution<double> noise(0.0, noise_size);
    const auto count = std::size_t(rate * (recording.release + 15.0 * period));
    for (std::size_t i = 0; i < count; ++i) {
        const double time = double(i) / rate;
        double motion = 0.0;
        const int parts = opening > 0.0 ? 10 : 1;
        for (int k = 0; k < parts; ++k) // the hand opens
            motion +=
                tip_motion((time - recording.release - opening * (k + 0.5) / parts) * frequency,
                           damping_ratio) /
                parts;
        if (kind == LetGo::AfterPull) { // as fast as the swing
            const double share = std::clamp((time - pull_begin) / (0.3 * period), 0.0, 1.0);
            motion = time < recording.release ? share * share * (3.0 - 2.0 * share) : motion;
        }
        recording.times.push_back(time);
        recording.positions.push_back(5.0 + 10.0 * motion + noise(generator));
    }
    return recording;
}

TEST(SwingRelease, IntervalCoversTheReleaseAtEveryRate) {
    std::mt19937 generator(17);
    constexpr int recordings = 200;
    int outside = 0;
    for (int k = 0; k < recordings; ++k) {
        const Recording recording = recorded(generator, static_cast<LetGo>(k % 3));
        const SwingRelease found = find_swing_release(recording.times, recording.positions, 1.0);
        EXPECT_LT(found.uncertainty, 0.07 * found.period);
        EXPECT_NEAR(found.rest, 5.0, 0.1);
        outside += std::abs(found.time - recording.release) > 1.96 * found.uncertainty ? 1 : 0;
    }
    // At most 16 of 200 intervals of 95 % are expected to miss (binomial, one in a hundred).
    EXPECT_LE(outside, 16);
}

/// A hand drifts by 3 mm before it lets go of a swing of 20 mm at 5 Hz, with noise, mm.
TEST(SwingRelease, FollowsAHandThatDrifts) {
    std::mt19937 dice(3);
    std::normal_distribution<double> noise(0.0, 0.03);
    for (int k = 0; k < 20; ++k) {
        const double release = 0.6 + 0.00131 * k; // at any place between two frames
        const auto hand = [](double t) { return 20.0 + 3.0 * std::sin(0.5 * pi * t); };
        std::vector<double> times;
        std::vector<double> positions;
        for (int i = 0; i < 400; ++i) {
            const double time = i / 200.0;
            const double since = time - release;
            const double swing =
                hand(release) * std::exp(-since) * std::cos(10.0 * pi * std::max(0.0, since));
            times.push_back(time);
            positions.push_back(noise(dice) + (since < 0.0 ? hand(time) : swing));
        }
        const SwingRelease found = find_swing_release(times, positions, 1.0);
        EXPECT_NEAR(found.time, release, 0.005);
    }
}

std::string refusal(const std::vector<double>& times, const std::vector<double>& positions) {
    try {
        static_cast<void>(find_swing_release(times, positions, 1.0));
    } catch (const core::InputError& error) {
        return error.what();
    }
    return {};
}

TEST(SwingRelease, RefusesRecordsWithoutAHold) {
    std::vector<double> times;
    std::vector<double> swing;
    std::vector<double> still;
    for (int i = 0; i < 300; ++i) {
        times.push_back(i / 100.0);
        swing.push_back(std::sin(10.0 * times.back()));
        still.push_back(0.001 * std::sin(37.0 * i));
    }
    EXPECT_NE(refusal(times, swing).find("in the middle of a swing"), std::string::npos);
    EXPECT_NE(refusal(times, still), "");
    EXPECT_NE(refusal({0.0, 0.1}, {1.0, 2.0}).find("fewer than 12"), std::string::npos);
}

TEST(SwingRelease, GapsHideNoHold) {
    std::mt19937 generator(5);
    Recording recording = recorded(generator, LetGo::ByString);
    const SwingRelease whole = find_swing_release(recording.times, recording.positions, 1.0);
    const double gap = std::numeric_limits<double>::quiet_NaN();
    for (std::size_t i = 0; i < recording.times.size(); ++i)
        if (const double cycles = (recording.times[i] - recording.release) / whole.period;
            (cycles > 0.6 && cycles < 1.1) || (cycles > 4.6 && cycles < 5.1))
            recording.positions[i] = gap;
    const SwingRelease found = find_swing_release(recording.times, recording.positions, 1.0);
    EXPECT_NEAR(found.time, recording.release, 3.0 * found.uncertainty);
}

TEST(CentreOfSwing, IsNotTheMeanOfAFewCycles) {
    std::vector<double> times;
    std::vector<double> positions;
    for (int i = 0; i < 430; ++i) { // 2.15 cycles
        times.push_back(0.005 * i);
        positions.push_back(3.0 + 10.0 * std::exp(-0.3 * times.back()) *
                                      std::cos(2.0 * pi * times.back()));
    }
    EXPECT_NEAR(centre_of_swing(times, positions, 0.0), 3.0, 0.05);
}

} // namespace
} // namespace culm::measure
