// SPDX-License-Identifier: BSD-3-Clause
// Records that begin while the stem swings in three modes, seen by an accelerometer, against the
// closed form of a slender beam: small damped motions of the first three modes.
#include "beam_generator/random_effect.hpp"
#include "core/cantilever.hpp"
#include "fit/fit_model.hpp"
#include "run/modes.hpp"
#include "support/single_fit.hpp"

#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include <fmt/core.h>
#include <gtest/gtest.h>

namespace culm::fit {
namespace {

/// A record, its first frequency (Hz) and the noise of its readings.
struct MovingRecord {
    measure::Measurement measurement;
    double frequency = 0.0;
    double noise = 0.0;
};

/// Modes 2 and 3 have 0.1 to 1 times the acceleration of mode 1; 30 to 60 cycles, damping ratios of
/// 0.3 to 1.5 %, and noise of a hundredth of mode 1.
MovingRecord moving_record(std::uint64_t number) {
    beam::Dice dice({11, beam::RandomUse::CaseDraw, number, 0});
    MovingRecord out;
    measure::Measurement& measurement = out.measurement;
    measurement.stem.id = fmt::format("moving-{}", number);
    measurement.stem.length = dice.between(0.2, 0.5);
    const double diameter = dice.between(2e-3, 5e-3);
    measurement.stem.section = measure::CircularSection{diameter, std::nullopt};
    measurement.stem.density = dice.between(300.0, 1200.0);
    measurement.release = measure::ReleaseKind::Moving;
    const double modulus = dice.log_between(1e9, 2e10);
    out.frequency = core::cantilever_frequency(
        measurement.stem.length, modulus * std::numbers::pi / 64.0 * std::pow(diameter, 4),
        measure::mass_per_length(measurement.stem));
    const double height = measurement.stem.length * dice.between(0.7, 0.95);
    measure::Sensor sensor;
    sensor.column = "acceleration";
    sensor.quantity = measure::Quantity::Acceleration;
    sensor.unit = "m/s2";
    sensor.offset_uncertainty = 1e-6;
    measurement.sensors = {sensor};
    measurement.heights = {height};
    const double first =
        0.01 * measurement.stem.length * std::pow(2.0 * std::numbers::pi * out.frequency, 2);
    std::array<std::complex<double>, 3> amplitudes; // of the acceleration
    std::array<std::complex<double>, 3> rates;
    for (std::size_t k = 0; k < 3; ++k) {
        const double omega = 2.0 * std::numbers::pi * out.frequency *
                             std::pow(core::cantilever_roots[k] / core::cantilever_roots[0], 2);
        rates[k] = {-omega * dice.log_between(0.003, 0.015), omega};
        amplitudes[k] = std::polar(first * (k == 0 ? 1.0 : dice.log_between(0.1, 1.0)),
                                   dice.between(-std::numbers::pi, std::numbers::pi));
    }
    out.noise = 0.01 * first;
    measurement.noise = out.noise;
    const double cycles = dice.between(30.0, 60.0);
    const double interval = 1.0 / (60.0 * out.frequency);
    measurement.frames_per_second = 1.0 / interval;
    for (int i = 0; i < static_cast<int>(60.0 * cycles); ++i) {
        const double time = i * interval;
        std::complex<double> sum = 0.0;
        for (std::size_t k = 0; k < 3; ++k)
            sum += amplitudes[k] * std::exp(rates[k] * time);
        measurement.times.push_back(time);
        measurement.deflections.push_back(
            sum.real() + out.noise * beam::normal({number, beam::RandomUse::Noise, 0,
                                                   static_cast<std::uint64_t>(i)}));
    }
    return out;
}

TEST(MovingStart, EndsInTheRightMinimumWithStrongHigherModes) {
    for (std::uint64_t number = 1; number <= 40; ++number) {
        const MovingRecord record = moving_record(number);
        FitOptions options;
        options.chain.spheres = 20;
        const Fit fit = fit_baseline({&record.measurement, 1}, options).fit;
        ASSERT_FALSE(fit.failed()) << number << ": " << fit.reason;
        const auto mode = run::lightly_damped_mode(fit.parts.front().model.spec);
        // A wrong cycle in 30 would be 3 %.
        EXPECT_NEAR(mode.frequency / record.frequency, 1.0, 3e-4) << number;
        EXPECT_LT(fit.parts.front().rmse, 1.1 * record.noise) << number;
    }
}

} // namespace
} // namespace culm::fit
