// SPDX-License-Identifier: BSD-3-Clause
#include "core/error.hpp"
#include "reduce/distributions.hpp"
#include "reduce/ring_down/ring_down_fit.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace {

using namespace culm::reduce;

constexpr double amplitude = 0.02; // m
constexpr double decay = -18.0;    // 1/s
constexpr double frequency = 60.0; // Hz
constexpr double sigma = 5e-5;     // m

struct Signal {
    std::vector<double> times;
    std::vector<double> values;
};

Signal clean(double offset = 0.0, double phase = 0.0) {
    Signal signal;
    for (int i = -5; i < 290; ++i) {
        const double t = i / 960.0;
        const double s = std::max(t, 0.0);
        signal.times.push_back(t);
        signal.values.push_back(offset +
                                amplitude * std::exp(decay * s) *
                                    std::cos(2.0 * std::numbers::pi * frequency * s + phase));
    }
    return signal;
}

/// Adds first-order autoregressive noise with the standard deviation sigma.
Signal noisy(Signal signal, double correlation, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal(0.0, sigma);
    double noise = normal(random);
    for (double& value : signal.values) {
        value += noise;
        noise = correlation * noise + std::sqrt(1.0 - correlation * correlation) * normal(random);
    }
    return signal;
}

RingDownOptions with_noise() {
    RingDownOptions options{.is_measured = true};
    options.noise = sigma;
    return options;
}

struct Coverage {
    double reported = 0.0;    ///< share of intervals of b1 per cycle that contain the truth
    double independent = 0.0; ///< the same if residuals are assumed independent
};

Coverage coverage(double correlation) {
    constexpr int experiments = 300;
    Coverage result;
    for (int i = 0; i < experiments; ++i) {
        const Signal signal = noisy(clean(), correlation, 100U + static_cast<unsigned>(i));
        const RingDownFit fit = fit_ring_down(signal.times, signal.values, {.is_measured = true});
        const double error = std::abs(fit.decay_per_cycle.value - decay / frequency);
        result.reported += error < fit.decay_per_cycle.upper - fit.decay_per_cycle.value;
        result.independent += error < 1.97 * fit.independent_decay_error;
    }
    return {result.reported / experiments, result.independent / experiments};
}

// Shares of 300 experiments scatter by 0.013 about 0.95.
TEST(MeasuredRingDown, IntervalsCoverTheTruthWithWhiteNoise) {
    const Coverage found = coverage(0.0);
    EXPECT_GT(found.reported, 0.92);
    EXPECT_NEAR(found.independent, 0.95, 0.045);
}

TEST(MeasuredRingDown, IntervalsCoverTheTruthWithCorrelatedNoise) {
    const Coverage found = coverage(0.9);
    EXPECT_GT(found.reported, 0.90);
    // The usual interval fails here, which is the reason for the reported one. b1 depends on the
    // noise near 60 Hz, where this noise is not strongest.
    EXPECT_LT(found.independent, found.reported);
}

TEST(MeasuredRingDown, FindsTheParametersThroughGapsAndIgnoresFramesBeforeTheRelease) {
    Signal signal = clean();
    for (std::size_t i = 7; i < signal.values.size(); i += 5)
        signal.values[i] = std::numeric_limits<double>::quiet_NaN();
    signal.values[0] = 1.0;
    const RingDownFit fit = fit_ring_down(signal.times, signal.values, {.is_measured = true});
    EXPECT_NEAR(fit.amplitude.value, amplitude, 1e-10);
    EXPECT_NEAR(fit.decay_rate.value, decay, 1e-7);
    EXPECT_NEAR(fit.frequency.value, frequency, 1e-8);
    EXPECT_NEAR(fit.decay_per_cycle.value, decay / frequency, 1e-9);
    EXPECT_LT(fit.samples, 290U);
}

TEST(MeasuredRingDown, FindsRestPositionAndPhaseOnRequest) {
    const Signal signal = clean(0.01, 0.15);
    const RingDownFit fit = fit_ring_down(
        signal.times, signal.values, {.has_offset = true, .has_phase = true, .is_measured = true});
    EXPECT_NEAR(fit.offset.value, 0.01, 1e-9);
    EXPECT_NEAR(fit.phase.value, 0.15, 1e-7);
    EXPECT_NEAR(fit.frequency.value, frequency, 1e-6);
    EXPECT_NEAR(fit.decay_rate.value, decay, 1e-5);
    EXPECT_NEAR(fit.amplitude.value, amplitude, 1e-9);
}

TEST(MeasuredRingDown, IsAdequateForNoiseButNotForMotionThatEquation1Lacks) {
    const Signal noise_only = noisy(clean(), 0.0, 1);
    const RingDownFit good = fit_ring_down(noise_only.times, noise_only.values, with_noise());
    EXPECT_TRUE(good.adequacy.is_adequate) << good.adequacy.reason;
    EXPECT_NEAR(*good.adequacy.reduced_chi_squared, 1.0, 0.3);

    Signal second_mode = noise_only;
    for (std::size_t i = 0; i < second_mode.times.size(); ++i)
        if (second_mode.times[i] > 0.0)
            second_mode.values[i] += 3e-4 * std::exp(-30.0 * second_mode.times[i]) *
                                     std::sin(2.0 * std::numbers::pi * 97.0 * second_mode.times[i]);
    const RingDownFit bad = fit_ring_down(second_mode.times, second_mode.values, with_noise());
    EXPECT_FALSE(bad.adequacy.is_adequate);
    EXPECT_NE(bad.adequacy.reason.find("x noise"), std::string::npos);
    EXPECT_FALSE(fit_ring_down(second_mode.times, second_mode.values, {.is_measured = true})
                     .adequacy.is_adequate);
    EXPECT_GT(bad.decay_per_cycle.standard_error, good.decay_per_cycle.standard_error);
}

TEST(MeasuredRingDown, RefusesTooFewReadings) {
    const std::vector<double> times{0.0, 0.1, 0.2, 0.3};
    const std::vector<double> values{1.0, 0.5, -0.5, 0.2};
    EXPECT_THROW(static_cast<void>(fit_ring_down(times, values)), culm::core::NumericalError);
}

TEST(ResidualTests, RejectNoiseAtTheirLevelAndCatchPatterns) {
    int runs_alarms = 0;
    int box_alarms = 0;
    std::mt19937 random(9);
    std::normal_distribution<double> normal;
    constexpr int experiments = 1000;
    std::vector<double> residuals(200);
    for (int i = 0; i < experiments; ++i) {
        for (double& residual : residuals)
            residual = normal(random);
        runs_alarms += runs_p_value(residuals) < 0.05;
        box_alarms += ljung_box_p_value(residuals, 15) < 0.05;
    }
    // 50 expected, standard deviation 7.
    EXPECT_NEAR(runs_alarms, 50, 25);
    EXPECT_NEAR(box_alarms, 50, 25);
    for (std::size_t t = 0; t < residuals.size(); ++t)
        residuals[t] = std::sin(0.4 * double(t));
    EXPECT_LT(runs_p_value(residuals), 1e-6);
    EXPECT_LT(ljung_box_p_value(residuals, 15), 1e-6);
    // Table: P(chi2 with 10 degrees of freedom >= 18.307) = 0.05.
    EXPECT_NEAR(chi_squared_p_value(18.307, 10.0), 0.05, 1e-5);
}

} // namespace
