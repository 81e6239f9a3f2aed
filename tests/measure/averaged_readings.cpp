// SPDX-License-Identifier: BSD-3-Clause
// Long records are averaged down, with the noise of the means.
#include "measure/folder/measurement_files.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace {

using namespace culm::measure;

constexpr double frequency = 37.0; // Hz
constexpr double rate = 51'200.0;  // readings per second
constexpr double amplitude = 8e-3; // m
constexpr double noise = 1e-5;     // m

double true_deflection(double time) {
    return time < 0.0 ? amplitude
                      : amplitude * std::exp(-0.5 * time) *
                            std::cos(2.0 * std::numbers::pi * frequency * time);
}

/// Two seconds, held for 0.1 s, with errors of the correlation r from reading to reading.
Measurement long_record(double r) {
    std::mt19937_64 random(5);
    std::normal_distribution<double> normal(0.0, noise);
    Measurement measurement;
    measurement.stem.length = 0.15;
    measurement.heights = {0.14};
    measurement.noise = noise;
    if (r > 0.0)
        measurement.noise_correlation = r;
    double error = normal(random);
    for (int k = -5'120; k < 102'400; ++k) {
        measurement.times.push_back(k / rate);
        error = r * error + std::sqrt(1.0 - r * r) * normal(random);
        measurement.deflections.push_back(true_deflection(k / rate) + error);
    }
    return measurement;
}

/// Scatter of the readings about the truth.
double scatter(const Measurement& measurement) {
    double sum = 0.0;
    for (std::size_t k = 0; k < measurement.times.size(); ++k)
        sum += std::pow(measurement.deflections[k] - true_deflection(measurement.times[k]), 2);
    return std::sqrt(sum / double(measurement.times.size()));
}

TEST(AveragedReadings, HaveTheNoiseOfMeans) {
    for (const double r : {0.0, 0.6}) {
        Measurement measurement = long_record(r);
        average_readings("S", measurement);
        // 51 200/37 readings per cycle over 60 of the second mode, 6.267 times as fast.
        EXPECT_NEAR(measurement.times[1] - measurement.times[0], 3.0 / rate, 1e-12);
        ASSERT_EQ(measurement.remarks.size(), 1U);
        EXPECT_NE(measurement.remarks[0].find("are averaged in groups of 3"), std::string::npos)
            << measurement.remarks[0];
        EXPECT_NEAR(scatter(measurement), *measurement.noise, 0.03 * *measurement.noise) << r;
        // Of three readings: (3 + 2 (2 r + r²))/9 of the variance.
        EXPECT_NEAR(*measurement.noise, noise * std::sqrt(3.0 + 4.0 * r + 2.0 * r * r) / 3.0,
                    0.02 * noise);
    }
}

TEST(AveragedReadings, KeepTheReleaseBetweenTwoMeansAndGapsAsGaps) {
    Measurement measurement = long_record(0.0);
    for (std::size_t k = 9'000; k < 9'020; ++k)
        measurement.deflections[k] = std::nan("");
    average_readings("S", measurement);
    const auto release =
        std::ranges::lower_bound(measurement.times, 0.0) - measurement.times.begin();
    EXPECT_NEAR(measurement.times[std::size_t(release)], 1.0 / rate, 1e-12);
    EXPECT_NEAR(measurement.times[std::size_t(release) - 1], -2.0 / rate, 1e-12);
    EXPECT_EQ(std::ranges::count_if(measurement.deflections,
                                    [](double value) { return std::isnan(value); }),
              7);
}

TEST(AveragedReadings, FollowTheFileAndLeaveShortRecordsAlone) {
    Measurement kept = long_record(0.0);
    kept.readings_per_mean = 1;
    average_readings("S", kept);
    EXPECT_EQ(kept.times.size(), 107'520U);
    Measurement coarse = long_record(0.0);
    coarse.readings_per_mean = 10;
    average_readings("S", coarse);
    EXPECT_NEAR(coarse.times[1] - coarse.times[0], 10.0 / rate, 1e-12);
    Measurement brief = long_record(0.0);
    brief.times.resize(19'000);
    brief.deflections.resize(19'000);
    average_readings("S", brief);
    EXPECT_EQ(brief.times.size(), 19'000U);
    EXPECT_TRUE(brief.remarks.empty());
}

TEST(StemLine, GivesWhatAPersonCanCheck) {
    MeasuredStem steel;
    steel.length = 0.3;
    steel.section = CircularSection{5e-3, std::nullopt};
    steel.density = 7850.0;
    // 2/3 of 7850 kg/m³ · π/4 · (5 mm)²; f ∝ √(206 GPa/1.5).
    EXPECT_EQ(stem_line(steel, 137.4e9),
              "300 mm, 5 mm, 30.83 g (103 g/m; 154 g/m if density_kg_m3 is that of the material), "
              "EI 4.22 N m² at Y = 137.4 GPa, beam theory b2 = 39.82 Hz");
    steel.is_density_of_spheres = false;
    EXPECT_EQ(stem_line(steel, 137.4e9).find("if density_kg_m3"), std::string::npos);
    EXPECT_NEAR(beam_frequency(steel, 206e9 / 1.5) / 39.81, 1.0, 1e-3);
}

TEST(DoubtOfZero, IsThatOfReadingsFromTheHeldPosition) {
    Measurement measurement = long_record(0.0);
    EXPECT_EQ(doubt_of_zero(measurement, 0.25), "");
    for (double& value : measurement.deflections)
        value -= amplitude;
    EXPECT_NE(doubt_of_zero(measurement, 0.4).find("the stem swings about -8"), std::string::npos);
}

} // namespace
