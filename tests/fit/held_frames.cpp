// SPDX-License-Identifier: BSD-3-Clause
// Frames before the release on a support that vibrates.
#include "fit/chain/stem_model.hpp"
#include "support/simulated_measurement.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace {

using namespace culm;

constexpr double amplitude = 2e-4;
constexpr double frequency = 90.0;
constexpr double phase = 0.7;

fit::StemModel on_vibrating_support(const measure::Measurement& measurement) {
    const physics::SelectedEffect effect = physics::parse_effect("base_motion", {});
    fit::StemModel model =
        fit::with_effect(tests::true_model(measurement, {}), effect, measurement);
    model.spec.effects.front().values = {amplitude, frequency, phase};
    return model;
}

TEST(HeldFrames, MoveWithTheSupport) {
    const measure::Measurement measurement = tests::empty_measurement();
    const fit::StemModel model = on_vibrating_support(measurement);
    std::vector<double> times = measurement.times;
    times.insert(times.begin() + 5, model.release_time); // the frame of the release itself
    std::ranges::sort(times);
    const auto predicted = fit::predict_readings(model, times);
    const auto at_release =
        static_cast<std::size_t>(std::ranges::find(times, model.release_time) - times.begin());
    const auto support = [](double since_release) {
        return amplitude * std::sin(2.0 * std::numbers::pi * frequency * since_release + phase);
    };
    ASSERT_EQ(at_release, 6U);
    for (std::size_t i = 0; i < at_release; ++i)
        for (std::size_t j = 0; j < predicted.rows; ++j)
            // Rounding only.
            EXPECT_NEAR(predicted.readings[i * predicted.rows + j] -
                            predicted.readings[at_release * predicted.rows + j],
                        support(times[i] - model.release_time) - support(0.0), 1e-14);
}

TEST(HeldFrames, DoNotMoveWithoutAVibratingSupport) {
    const measure::Measurement measurement = tests::empty_measurement();
    const auto predicted =
        fit::predict_readings(tests::true_model(measurement, {}), measurement.times);
    for (std::size_t k = 0; k < 5 * predicted.rows; ++k)
        EXPECT_EQ(predicted.readings[k], predicted.readings[k % predicted.rows]);
}

// The first frames contain modes that are faster than the exposure; the release excites them.
TEST(ExposedFrames, AreMeansOfTheMotion) {
    const measure::Measurement measurement = tests::empty_measurement();
    fit::StemModel model = tests::true_model(measurement, {});
    constexpr double exposure = 0.7e-3;
    constexpr int parts = 40;
    std::vector<double> fine;
    for (const double time : measurement.times)
        for (int part = 0; part < parts; ++part)
            fine.push_back(time + exposure * ((part + 0.5) / parts - 0.5));
    const auto moments = fit::predict_readings(model, fine);
    model.exposure = exposure;
    const auto exposed = fit::predict_readings(model, measurement.times);
    double largest = 0.0;
    double smear = 0.0;
    for (std::size_t i = 0; i < measurement.times.size(); ++i)
        for (std::size_t j = 0; j < exposed.rows; ++j) {
            double mean = 0.0;
            for (int part = 0; part < parts; ++part)
                mean +=
                    moments.readings[(i * parts + std::size_t(part)) * exposed.rows + j] / parts;
            const double reading = exposed.readings[i * exposed.rows + j];
            if (measurement.times[i] - model.release_time > exposure)
                largest = std::max(largest, std::abs(reading - mean));
            smear = std::max(
                smear,
                std::abs(mean - moments.readings[(i * parts + parts / 2) * exposed.rows + j]));
        }
    EXPECT_GT(smear, 50e-6);
    EXPECT_LT(largest, 2e-6);
}

TEST(HeldFrames, HaveTheDerivativesOfTheirReadings) {
    const measure::Measurement measurement = tests::empty_measurement();
    const fit::StemModel model = on_vibrating_support(measurement);
    const std::vector<double> times(measurement.times.begin(), measurement.times.begin() + 5);
    const auto predicted = fit::predict_readings(model, times);
    const auto difference = [&](std::size_t reading, const auto& change, double step) {
        fit::StemModel below = model;
        fit::StemModel above = model;
        change(below, -step);
        change(above, step);
        return (fit::predict_readings(above, times).readings[reading] -
                fit::predict_readings(below, times).readings[reading]) /
               (2.0 * step);
    };
    const std::vector<physics::ParameterId> ids = model.free_ids();
    ASSERT_EQ(ids.back(), physics::release_time);
    for (const std::size_t reading : {std::size_t{0}, std::size_t{13}})
        for (std::size_t k = 0; k < ids.size(); ++k) {
            const bool is_release = k + 1 == ids.size();
            // The step is relative to the size of a parameter, or to a millisecond for the time.
            const double size =
                is_release ? 1e-3 : std::abs(model.parameters[k].access.get(model.spec));
            const double found = difference(
                reading,
                [&](fit::StemModel& changed, double step) {
                    if (is_release)
                        changed.release_time += step;
                    else
                        model.parameters[k].access.set(
                            changed.spec, model.parameters[k].access.get(model.spec) + step);
                },
                1e-4 * size);
            // Curvature over the step (1e-8) and derivatives in lanes (1e-5 of the largest).
            const double by_value =
                predicted.jacobian[reading * predicted.parameters + k] * model.coordinate_slope(k);
            EXPECT_NEAR(by_value * size, found * size, 1e-7) << to_string(ids[k]);
        }
}

} // namespace
