// SPDX-License-Identifier: BSD-3-Clause
#include "measure/folder/observation.hpp"

#include <cmath>
#include <numbers>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

namespace culm::measure {
namespace {

constexpr int spheres = 56;
constexpr double bond_length = 2.83e-3;
constexpr double length = bond_length * (spheres - 1);

/// A strongly bent chain, (spheres, dimensions).
std::vector<double> bent_chain(int dimensions, double tip_angle) {
    std::vector<double> positions;
    double axial = 0.0;
    double lateral = 0.0;
    for (int i = 0; i < spheres; ++i) {
        positions.push_back(axial);
        positions.push_back(lateral);
        if (dimensions == 3)
            positions.push_back(1e-3 * i);
        const double angle = tip_angle * std::sin(0.5 * std::numbers::pi * i / (spheres - 1));
        axial += bond_length * std::cos(angle);
        lateral += bond_length * std::sin(angle);
    }
    return positions;
}

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

TEST(CameraRow, SeesNothingAboveTheTipOrBelowTheClamp) {
    const auto positions = centres_on([](double x) { return x; }, 2);
    EXPECT_TRUE(std::isnan(deflection_in_row(positions, 2, 0.2)));
    EXPECT_TRUE(std::isnan(deflection_in_row(positions, 2, -0.001)));
}

TEST(Mark, IsReadAlongTheUndeformedStem) {
    for (const int dimensions : {2, 3}) {
        const std::vector<double> positions = bent_chain(dimensions, 0.6);
        const auto stride = static_cast<std::size_t>(dimensions);
        const auto at = [&](double height) {
            return deflection_of_mark(positions, dimensions, bond_length, height);
        };
        for (const std::size_t i : {0U, 1U, 20U, 54U, 55U})
            EXPECT_NEAR(at(bond_length * double(i)), positions[stride * i + 1], 1e-15);
        EXPECT_FALSE(std::isnan(at(length * (1.0 + 1e-12))));
        EXPECT_TRUE(std::isnan(at(length * 1.1)));
        EXPECT_TRUE(std::isnan(at(-1e-3)));
    }
}

TEST(CameraRow, DoesNotChangeWhenTheCurveSlidesAlongItself) {
    const std::vector<double> positions = bent_chain(2, 0.6);
    // Along the tangent at each sphere, 1e-6 m to either side.
    const auto slid = [&](double way) {
        std::vector<double> moved = positions;
        for (int i = 0; i < spheres; ++i) {
            const double angle = 0.6 * std::sin(0.5 * std::numbers::pi * (i - 0.5) / (spheres - 1));
            moved[2 * static_cast<std::size_t>(i)] += way * std::cos(angle);
            moved[2 * static_cast<std::size_t>(i) + 1] += way * std::sin(angle);
        }
        return moved;
    };
    const auto forward = slid(1e-6);
    const auto backward = slid(-1e-6);
    for (const double height : {0.0011, 0.0142, 0.0501, 0.0777, 0.1103, 0.1296}) {
        const double change =
            deflection_in_row(forward, 2, height) - deflection_in_row(backward, 2, height);
        // Tangents of the polygon differ from those of its cubic by (l κ)²/24, κ up to 6/m.
        EXPECT_NEAR(change / 2e-6, 0.0, 1e-4);
        // A mark moves with the curve.
        if (height > 0.05) {
            EXPECT_GT((deflection_of_mark(forward, 2, bond_length, height) -
                       deflection_of_mark(backward, 2, bond_length, height)) /
                          2e-6,
                      0.1);
        }
    }
}

TEST(CameraRow, ErrorOnCantileverModesStaysBelowTheStatedBound) {
    // Modes 1 and 2 of a cantilever, tip deflection 1, and their fourth derivative (kL)⁴/L⁴ y.
    for (const auto& [kl, sigma, stated] : {std::tuple{1.8751040687, 0.7340955138, 6e-8},
                                            std::tuple{4.6940911330, 1.0184673188, 2.3e-6}}) {
        const auto mode = [kl = kl, sigma = sigma](double s) {
            const double x = kl * s / length;
            return 0.5 * (std::cosh(x) - std::cos(x) - sigma * (std::sinh(x) - std::sin(x)));
        };
        std::vector<double> positions;
        for (int i = 0; i < spheres; ++i) {
            positions.push_back(bond_length * i);
            positions.push_back(mode(bond_length * i));
        }
        double largest = 0.0;
        for (double height = 0.0; height < length; height += 0.1e-3)
            largest =
                std::max(largest, std::abs(deflection_in_row(positions, 2, height) - mode(height)));
        EXPECT_LT(largest, stated);
        EXPECT_GT(largest, 0.2 * stated);
    }
}

TEST(TimeStencil, IsExactOnCubicsAndTheirRates) {
    std::vector<double> sample_times;
    std::vector<double> table;
    const auto cubic = [](double t) { return 1.0 + 2.0 * t - 3.0 * t * t + 4.0 * t * t * t; };
    for (int i = 0; i < 12; ++i) {
        sample_times.push_back(0.1 * i + 0.01 * std::sin(double(i * i)));
        table.push_back(cubic(sample_times.back()));
        table.push_back(-cubic(sample_times.back()));
    }
    const std::vector<double> times{0.003, 0.25, 0.31, 0.77, 1.05, sample_times[4]};
    for (const double t : times) {
        const TimeStencil stencil = time_stencil(sample_times, t);
        EXPECT_NEAR(stencil.value(table, 2, 0), cubic(t), 1e-13);
        EXPECT_NEAR(stencil.value(table, 2, 1), -cubic(t), 1e-13);
        EXPECT_NEAR(stencil.rate(table, 2, 0), 2.0 - 6.0 * t + 12.0 * t * t, 1e-12);
    }
}

TEST(TimeStencil, HoldsTheStemBeforeTheReleaseAndSeesNothingAfterTheLastSample) {
    const std::vector<double> sample_times{0.0, 0.1, 0.2, 0.3, 0.4};
    const std::vector<double> table{5.0, 4.0, 2.0, -1.0, -2.0};
    const auto value = [&](double t) { return time_stencil(sample_times, t).value(table, 1, 0); };
    const auto rate = [&](double t) { return time_stencil(sample_times, t).rate(table, 1, 0); };
    EXPECT_EQ(value(-0.5), 5.0);
    EXPECT_EQ(rate(-0.5), 0.0);
    EXPECT_EQ(value(0.0), 5.0);
    EXPECT_NEAR(value(0.4 + 1e-11), -2.0, 1e-9);
    EXPECT_TRUE(std::isnan(value(0.41)));
    EXPECT_TRUE(std::isnan(rate(0.41)));
}

TEST(TimeStencil, ErrorOnAVibrationIsThatStated) {
    std::vector<double> sample_times;
    std::vector<double> table;
    const double omega = 2.0 * std::numbers::pi * 60.0;
    for (int i = 0; i < 400; ++i) {
        sample_times.push_back(1e-4 * i);
        table.push_back(std::cos(omega * sample_times.back()));
    }
    double largest = 0.0;
    for (double t = 1e-3; t < 0.038; t += 1.7e-5)
        largest = std::max(largest, std::abs(time_stencil(sample_times, t).value(table, 1, 0) -
                                             std::cos(omega * t)));
    EXPECT_LT(largest, 5e-8);
    EXPECT_GT(largest, 3e-8);
}

} // namespace
} // namespace culm::measure
