// SPDX-License-Identifier: BSD-3-Clause
// What a person can check about a stem and the zero of its readings.
#include "measure/folder/measurement.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace {

using namespace culm::measure;

TEST(StemLine, GivesWhatAPersonCanCheck) {
    MeasuredStem steel;
    steel.length = 0.3;
    steel.section = CircularSection{5e-3, std::nullopt};
    steel.density = 7850.0;
    // 2/3 of 7850 kg/m³ · π/4 · (5 mm)²; f ∝ √(206 GPa/1.5).
    EXPECT_EQ(stem_line(steel, 137.4e9),
              "300 mm, 5 mm, 30.83 g (103 g/m as touching spheres of this density; 154 g/m as a "
              "rod), EI 4.22 N m² at Y = 137.4 GPa, beam theory b2 = 39.82 Hz");
    steel.is_density_of_spheres = false;
    EXPECT_EQ(stem_line(steel, 137.4e9).find("touching spheres"), std::string::npos);
    EXPECT_NEAR(beam_frequency(steel, 206e9 / 1.5) / 39.81, 1.0, 1e-3);
}

TEST(StemLine, DoubtsAModulusThatNoMaterialHas) {
    MeasuredStem stem;
    stem.length = 0.3;
    stem.section = CircularSection{5e-3, std::nullopt};
    stem.density = 7850.0;
    EXPECT_EQ(stem_line(stem, 3e9).find("no material"), std::string::npos);
    EXPECT_NE(stem_line(stem, 3e12).find("no material has this Y"), std::string::npos);
    EXPECT_NE(stem_line(stem, 3e3).find("no material has this Y"), std::string::npos);
}

TEST(DoubtOfZero, IsThatOfReadingsFromTheHeldPosition) {
    constexpr double amplitude = 8e-3; // m
    Measurement measurement;
    measurement.heights = {0.14};
    for (int k = 0; k < 2000; ++k) {
        const double time = k / 1000.0;
        measurement.times.push_back(time);
        measurement.deflections.push_back(amplitude * std::exp(-0.5 * time) *
                                          std::cos(2.0 * std::numbers::pi * 37.0 * time));
    }
    EXPECT_EQ(doubt_of_zero(measurement, false), "");
    for (double& value : measurement.deflections)
        value -= amplitude;
    EXPECT_NE(doubt_of_zero(measurement, true).find("the stem swings about -8"), std::string::npos);
    // A stem that is curved at rest begins anywhere.
    for (double& value : measurement.deflections)
        value += 5.0 * amplitude;
    EXPECT_NE(doubt_of_zero(measurement, false), "");
    EXPECT_EQ(doubt_of_zero(measurement, true), "");
}

} // namespace
