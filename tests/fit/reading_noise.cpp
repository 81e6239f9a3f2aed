// SPDX-License-Identifier: BSD-3-Clause
#include "fit/noise/reading_noise.hpp"

#include "support/simulated_measurement.hpp"

#include <gtest/gtest.h>

namespace {

using namespace culm;

TEST(ReadingNoise, EqualsTheNoiseThatTheMeasurementStates) {
    const auto noise = fit::reading_noise(fit::ObservedRecording(tests::simulated_measurement()));
    EXPECT_EQ(noise.by_row, std::vector<double>(4, 0.05e-3));
    EXPECT_EQ(noise.source, "stated");
}

TEST(ReadingNoise, ComesFromTheFramesBeforeTheRelease) {
    measure::Measurement measurement = tests::empty_measurement();
    for (int frame = 1; frame <= 60; ++frame) // to 65 frames before the release
        measurement.times.insert(measurement.times.begin(), -5e-3 - 1e-3 * frame);
    measurement.deflections.assign(measurement.times.size() * measurement.heights.size(), 0.0);
    measurement = tests::read_with_noise(measurement, tests::true_model(measurement, {}), 3);
    measurement.noise.reset();
    const auto noise = fit::reading_noise(fit::ObservedRecording(measurement));
    ASSERT_EQ(noise.by_row.size(), 4U);
    // 252 degrees of freedom: 4.5 % standard error.
    EXPECT_NEAR(noise.by_row.front(), 0.05e-3, 0.2 * 0.05e-3);
    EXPECT_EQ(noise.source, "64 frames while the stem was held");
}

TEST(ReadingNoise, IsUnknownWithoutFramesBeforeTheRelease) {
    measure::Measurement measurement = tests::simulated_measurement();
    measurement.noise.reset();
    measurement.times.erase(measurement.times.begin(), measurement.times.begin() + 5);
    measurement.deflections.erase(measurement.deflections.begin(),
                                  measurement.deflections.begin() + 20);
    EXPECT_TRUE(fit::reading_noise(fit::ObservedRecording(measurement)).by_row.empty());
}

} // namespace
