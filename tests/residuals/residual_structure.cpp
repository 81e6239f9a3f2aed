// SPDX-License-Identifier: BSD-3-Clause
#include "residuals/residual_structure.hpp"

#include "fit/chain/stem_model.hpp"

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace culm::tests {
namespace {

constexpr double frequency = 50.0;
constexpr double noise = 0.02e-3;

/// A model that swings as 10 mm exp(−6t) cos(2π 50 t) in one row, and the measured swing.
struct Example {
    fit::RecordingFit fit;
    residuals::Swing swing;

    /// The noise is autoregressive of first order with this correlation.
    explicit Example(const std::function<double(double time, double modelled)>& measured,
                     double correlation = 0.0, unsigned seed = 4) {
        std::mt19937 generator(seed);
        std::normal_distribution<double> normal(0.0, noise);
        double error = normal(generator);
        fit.prediction.rows = 1;
        fit.noise = {noise};
        for (int frame = 0; frame < 600; ++frame) {
            const double time = 1e-3 * frame;
            const double omega = 2.0 * std::numbers::pi * frequency;
            const double size = 10e-3 * std::exp(-6.0 * time);
            swing.times.push_back(time);
            swing.modelled.push_back(size * std::cos(omega * time));
            swing.modelled_speed.push_back(-omega * size * std::sin(omega * time));
            swing.measured.push_back(measured(time, swing.modelled.back()) + error);
            error = correlation * error +
                    std::sqrt(1.0 - correlation * correlation) * normal(generator);
            fit.residuals.push_back(swing.measured.back() - swing.modelled.back());
        }
        fit.times = swing.times;
        swing.noise = noise;
        swing.noise_correlation = correlation;
        swing.frequency = frequency;
    }
    [[nodiscard]] residuals::ResidualStructure structure() const {
        return residuals::residual_structure(fit, swing);
    }
};

TEST(ResidualStructure, MeasuresAWrongAmplitude) {
    const auto found = Example([](double, double modelled) { return 1.05 * modelled; }).structure();
    EXPECT_GT(found.amplitude_share, 0.95);
    for (const residuals::SwingError& third : found.thirds)
        EXPECT_NEAR(third.amplitude, 0.05, 4.0 * third.amplitude_error);
}

TEST(ResidualStructure, MeasuresAPhaseLag) {
    const double lag = 0.05;
    const auto found = Example([lag](double time, double) {
                           const double omega = 2.0 * std::numbers::pi * frequency;
                           return 10e-3 * std::exp(-6.0 * time) * std::cos(omega * time - lag);
                       }).structure();
    EXPECT_GT(found.phase_share, 0.9);
    // The speed's own decay, 6/(2π 50), mixes 2 % of the lag into the amplitude.
    EXPECT_NEAR(found.thirds[0].lag, lag, 0.03 * lag);
}

TEST(ResidualStructure, MeasuresAShiftOfTheRestPosition) {
    const auto found =
        Example([](double, double modelled) { return modelled + 0.1e-3; }).structure();
    EXPECT_GT(found.rest_share, 0.9);
    for (const residuals::SwingError& third : found.thirds)
        EXPECT_NEAR(third.rest, 0.1e-3, 4.0 * third.rest_error);
}

TEST(ResidualStructure, KnowsWhereASwingHasDied) {
    const auto found = Example([](double time, double modelled) {
                           return time < 0.4 ? modelled : 0.0;
                       }).structure();
    // 10 mm exp(−6t) over the first 0.2 s: √(mean of exp(−12t)) is 0.62.
    EXPECT_NEAR(found.thirds[0].measured_over_noise, 0.62 * 10e-3 / noise, 5.0);
    EXPECT_NEAR(found.thirds[0].modelled_over_noise, found.thirds[0].measured_over_noise, 0.5);
    // The scatter of 200 readings is known to 5 %: pure noise gives at most √(2 · 0.05 …).
    EXPECT_LT(found.thirds[2].measured_over_noise, 1.0);
    EXPECT_GT(found.thirds[2].modelled_over_noise, 10.0);
}

// Noise that is correlated from frame to frame moves the position of rest by four times as much as
// white noise, and the amplitude by another factor.
TEST(ResidualStructure, HasTheErrorsOfCorrelatedNoise) {
    constexpr int count = 300;
    double rest = 0.0;
    double amplitude = 0.0;
    for (unsigned seed = 0; seed < count; ++seed) {
        const auto found =
            Example([](double, double modelled) { return modelled; }, 0.9, seed).structure();
        rest += std::pow(found.thirds[0].rest / found.thirds[0].rest_error, 2) / count;
        amplitude +=
            std::pow(found.thirds[0].amplitude / found.thirds[0].amplitude_error, 2) / count;
    }
    EXPECT_NEAR(rest, 1.0, 0.3); // the mean square of 300 scatters by 0.08
    EXPECT_NEAR(amplitude, 1.0, 0.3);
}

TEST(ResidualStructure, HasNoExcessForNoise) {
    const auto found = Example([](double, double modelled) { return modelled; }).structure();
    // The mean square of 600 readings scatters by √(2/600).
    EXPECT_NEAR(found.excess_over_noise, 0.0, 4.0 * std::sqrt(2.0 / 600.0));
}

} // namespace
} // namespace culm::tests
