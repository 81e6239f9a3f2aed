// SPDX-License-Identifier: BSD-3-Clause
// Sensors of a measurement folder: reading, refusals, and the observation operators against closed
// forms.
#include "measure/folder/observation.hpp"
#include "measure/measurement_files.hpp"

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace {

using namespace culm::tests;
using culm::measure::Quantity;
using culm::measure::Sensor;

const std::string sensor_tables =
    plain_stem + "[[sensor]]\ncolumn = \"acc\"\nquantity = \"acceleration\"\nunit = \"g\"\n"
                 "height_mm = 100\nmass_g = 5\nmass_uncertainty_g = 0.5\nnoise = 0.001\n"
                 "[[sensor]]\ncolumn = \"root\"\nquantity = \"strain\"\nunit = \"um/m\"\n"
                 "height_mm = 5\ndistance_from_axis_mm = 1.4\nhigh_pass_hz = 0.5\n";
const std::string sensor_table = "time_s,acc,root\n0,1.5,100\n0.001,,150\n0.0035,0.5,50\n"
                                 "0.004,1.5,150\n";

TEST(SensorTables, GiveColumnsInSiUnitsInTheOrderOfTheHeights) {
    const culm::measure::Measurement read = read_texts(sensor_tables, sensor_table);
    ASSERT_EQ(read.sensors.size(), 2U);
    EXPECT_EQ(read.sensors[0].column, "root");
    EXPECT_EQ(read.heights, (std::vector{0.005, 0.1}));
    EXPECT_EQ(read.times, (std::vector{0.0, 0.001, 0.0035, 0.004}));
    EXPECT_DOUBLE_EQ(read.sensors[0].high_pass, 0.5);
    EXPECT_DOUBLE_EQ(read.sensors[1].noise.value_or(0.0), 9.80665e-3);
    // The mean of so few readings, 112.5 µm/m and 3.5/3 g, is removed.
    EXPECT_NEAR(read.deflection(1, 0), 37.5e-6, 1e-12);
    EXPECT_NEAR(read.deflection(0, 1), 9.80665 / 3.0, 1e-12);
    EXPECT_TRUE(std::isnan(read.deflection(1, 1)));
    ASSERT_EQ(read.stem.added_masses.size(), 1U);
    EXPECT_DOUBLE_EQ(read.stem.added_masses[0].mass, 0.005);
    EXPECT_DOUBLE_EQ(*read.stem.added_masses[0].mass_uncertainty, 0.0005);
    EXPECT_EQ(culm::measure::reading_unit(read.sensors).name, "SI units");
    EXPECT_EQ(culm::measure::reading_unit({&read.sensors[1], 1}).name, "m/s²");
}

TEST(SensorTables, KeepTheSagOfASensorWhoseZeroIsStated) {
    const auto deflection_at_rest = [](const std::string& zero) {
        const culm::measure::Measurement read =
            read_texts(plain_stem +
                           "[[sensor]]\ncolumn = \"laser\"\nquantity = \"displacement\"\n"
                           "unit = \"mm\"\nheight_mm = 100\n" +
                           zero,
                       "time_s,laser\n0,5\n0.1,2\n0.2,3\n0.3,2\n");
        return read.deflection(3, 0);
    };
    EXPECT_NEAR(deflection_at_rest("offset_uncertainty = 0.1\n"), 2e-3, 1e-15);
    EXPECT_NEAR(deflection_at_rest(""), -1e-3, 1e-15);
}

TEST(SensorTables, KeepTheMassesOfEqualSensorsAtOneHeightApart) {
    const std::string twin =
        "[[sensor]]\ncolumn = \"b\"\nquantity = \"acceleration\"\nunit = \"g\"\n"
        "height_mm = 100\nmass_g = 5\n";
    const culm::measure::Measurement read =
        read_texts(sensor_tables + twin, "time_s,acc,root,b\n0,1,2,3\n0.001,2,3,4\n");
    EXPECT_EQ(read.stem.added_masses.size(), 2U);
    EXPECT_EQ(read.sensors.size(), 3U);
}

TEST(SensorTables, AreRefusedWithWhatToWrite) {
    const auto sensor = [](const std::string& lines) {
        return plain_stem + "[[sensor]]\ncolumn = \"acc\"\n" + lines;
    };
    const std::vector<std::pair<std::string, std::string>> cases{
        {sensor("quantity = \"accelaration\"\nunit = \"g\"\nheight_mm = 1\n"), "acceleration"},
        {sensor("quantity = \"acceleration\"\nunit = \"mm\"\nheight_mm = 1\n"),
         "must be a unit of acceleration: m/s2, mm/s2, g"},
        {sensor("quantity = \"acceleration\"\nunit = \"g\"\nheight_mm = 200\n"),
         "lies above the stem, which is 157 mm long"},
        {sensor("quantity = \"strain\"\nunit = \"um/m\"\nheight_mm = 1\n"),
         "distance_from_axis_mm"},
        {sensor("quantity = \"acceleration\"\nunit = \"g\"\nheight_mm = 1\nmas_g = 5\n"),
         "mass_g"}};
    for (const auto& [stem, message] : cases)
        EXPECT_NE(refusal_of(stem, sensor_table).find(message), std::string::npos)
            << refusal_of(stem, sensor_table);
    EXPECT_NE(
        refusal_of(sensor_tables, "time_s,acc\n0,1\n1,2\n").find("there is no column \"root\""),
        std::string::npos);
}

/// A chain whose curve is a circle of radius R, as positions of 11 spheres along the arc.
TEST(SensorReading, OfACircleIsThatOfGeometry) {
    constexpr double bond = 0.01;
    constexpr double radius = 0.5;
    std::vector<double> positions;
    std::vector<double> accelerations;
    for (int i = 0; i <= 10; ++i) {
        const double angle = i * bond / radius;
        positions.insert(positions.end(),
                         {radius * std::sin(angle), radius * (1.0 - std::cos(angle))});
        accelerations.insert(accelerations.end(), {-3.0, 2.0});
    }
    const culm::measure::ChainSample chain{positions, accelerations, accelerations};
    const double height = 0.047;
    const double angle = height / radius;
    const auto reading = [&](Quantity quantity) {
        Sensor sensor;
        sensor.column = "a";
        sensor.quantity = quantity;
        sensor.distance_from_axis = 0.002;
        return culm::measure::reading_of_sensor(sensor, chain, 2, bond, height,
                                                {0.1, 0.2, {-9.81, 0.0}});
    };
    EXPECT_NEAR(reading(Quantity::Displacement),
                radius * (1.0 - std::cos(angle)) + 0.002 * (std::cos(angle) - 1.0), 1e-8);
    EXPECT_NEAR(reading(Quantity::Velocity), 2.1, 1e-9);
    EXPECT_NEAR(reading(Quantity::Acceleration),
                2.2 * std::cos(angle) - (-3.0 + 9.81) * std::sin(angle), 1e-5);
    EXPECT_NEAR(reading(Quantity::Strain), -0.002 / radius, 2e-3 * 0.002 / radius);
}

TEST(SensorFilters, HaveTheGainOfAFirstOrderFilter) {
    constexpr double interval = 1e-4;
    constexpr double frequency = 5.0;
    for (const bool is_high_pass : {false, true}) {
        Sensor sensor;
        (is_high_pass ? sensor.high_pass : sensor.low_pass) = 2.0;
        std::vector<double> samples;
        for (int k = 0; k < 40000; ++k)
            samples.push_back(std::sin(2.0 * std::numbers::pi * frequency * k * interval));
        culm::measure::filter(sensor, interval, samples);
        double largest = 0.0;
        for (std::size_t k = 20000; k < samples.size(); ++k)
            largest = std::max(largest, samples[k]);
        const double ratio = frequency / 2.0;
        EXPECT_NEAR(largest, (is_high_pass ? ratio : 1.0) / std::hypot(1.0, ratio), 1e-4);
    }
}

} // namespace
