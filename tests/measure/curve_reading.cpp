// SPDX-License-Identifier: BSD-3-Clause
#include "measure/curve_reading.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace culm::measure {
namespace {

/// Centres on the curve lateral = f(axial), unevenly spaced.
template <class Curve>
std::vector<double> centres_on(const Curve& curve, int dimensions) {
    std::vector<double> positions;
    for (int i = 0; i < 20; ++i) {
        const double axial = 0.01 * i + 0.001 * std::sin(double(i));
        positions.push_back(axial);
        positions.push_back(curve(axial));
        if (dimensions == 3)
            positions.push_back(99.0);
    }
    return positions;
}

TEST(CameraRow, IsExactOnACubicInTwoAndThreeDimensions) {
    const auto cubic = [](double x) { return 0.3 - 2.0 * x + 5.0 * x * x + 7.0 * x * x * x; };
    for (const int dimensions : {2, 3}) {
        const auto positions = centres_on(cubic, dimensions);
        for (const double height : {0.0, 0.004, 0.0555, 0.13, 0.19})
            EXPECT_NEAR(deflection_in_row(positions, dimensions, height), cubic(height), 1e-14);
    }
}

TEST(CameraRow, GivesACentresOwnDeflectionInItsRow) {
    const auto positions = centres_on([](double x) { return std::sin(20 * x); }, 2);
    for (std::size_t i = 0; i < 20; ++i)
        EXPECT_NEAR(deflection_in_row(positions, 2, positions[2 * i]), positions[2 * i + 1], 1e-15);
}

TEST(CameraRow, ReadsTheSameWithAndWithoutDerivatives) {
    const auto positions = centres_on([](double x) { return std::sin(20 * x); }, 3);
    for (const double height : {0.0, 0.004, 0.0555, 0.13, 0.19})
        EXPECT_EQ(deflection_in_row(positions, 3, height),
                  read_row(positions, 3, height).deflection);
}

TEST(CameraRow, SeesNothingAboveTheTipOrBelowTheClamp) {
    const auto positions = centres_on([](double x) { return x; }, 2);
    EXPECT_TRUE(std::isnan(deflection_in_row(positions, 2, 0.2)));
    EXPECT_TRUE(std::isnan(deflection_in_row(positions, 2, -0.001)));
    EXPECT_EQ(read_row(positions, 2, 0.2).spheres, 0U);
}

} // namespace
} // namespace culm::measure
