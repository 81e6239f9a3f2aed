// SPDX-License-Identifier: BSD-3-Clause
#include "measure/observation.hpp"

#include <cmath>
#include <numbers>
#include <random>

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

/// Rows between the centres, so that a finite difference does not change the four spheres.
const std::vector<double> heights{0.0011, 0.0142, 0.0501, 0.0777, 0.1103, 0.1296};

void expect_derivatives_match(Reading reading, int dimensions) {
    const ObservedPlaces places{reading, heights, dimensions, bond_length};
    std::vector<double> positions = bent_chain(dimensions, 0.6);
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> shift(-1.0, 1.0);
    std::vector<double> direction(positions.size());
    for (double& component : direction)
        component = shift(random);
    const double step = 1e-7; // m; a bond is 2.83e-3 m
    const auto at = [&](double sign) {
        std::vector<double> moved = positions;
        for (std::size_t i = 0; i < moved.size(); ++i)
            moved[i] += sign * step * direction[i];
        return read_frame(places, moved);
    };
    const auto readings = read_frame(places, positions);
    const auto forward = at(1.0);
    const auto backward = at(-1.0);
    for (std::size_t j = 0; j < heights.size(); ++j) {
        const double difference = (forward[j].deflection - backward[j].deflection) / (2.0 * step);
        // Central differences: (step/l)² = 1e-9 of truncation, 1e-17/1e-7 = 1e-10 of rounding.
        EXPECT_NEAR(readings[j].derivative(direction, dimensions), difference, 1e-7) << j;
        EXPECT_GT(std::abs(difference), 1e-3);
    }
}

TEST(CurveReading, DerivativesAreThoseOfFiniteDifferences) {
    for (const int dimensions : {2, 3}) {
        expect_derivatives_match(Reading::Row, dimensions);
        expect_derivatives_match(Reading::Material, dimensions);
    }
}

TEST(CurveReading, RowDoesNotChangeWhenTheCurveSlidesAlongItself) {
    const std::vector<double> positions = bent_chain(2, 0.6);
    // Along the tangent at each sphere, at unit speed.
    std::vector<double> slide(positions.size());
    for (int i = 0; i < spheres; ++i) {
        const double angle = 0.6 * std::sin(0.5 * std::numbers::pi * (i - 0.5) / (spheres - 1));
        slide[2 * static_cast<std::size_t>(i)] = std::cos(angle);
        slide[2 * static_cast<std::size_t>(i) + 1] = std::sin(angle);
    }
    for (const double height : heights) {
        // Tangents of the polygon differ from those of its cubic by (l κ)²/24, κ up to 6/m.
        EXPECT_NEAR(read_row(positions, 2, height).derivative(slide, 2), 0.0, 1e-4);
        // A mark does move along.
        if (height > 0.05) {
            EXPECT_GT(read_mark(positions, 2, bond_length, height).derivative(slide, 2), 0.1);
        }
    }
}

TEST(CurveReading, MarkIsReadAlongTheUndeformedStem) {
    const std::vector<double> positions = bent_chain(2, 0.6);
    for (const std::size_t i : {0U, 1U, 20U, 54U, 55U})
        EXPECT_NEAR(read_mark(positions, 2, bond_length, bond_length * double(i)).deflection,
                    positions[2 * i + 1], 1e-15);
    EXPECT_GT(read_mark(positions, 2, bond_length, length * (1.0 + 1e-12)).spheres, 0U);
    EXPECT_TRUE(std::isnan(read_mark(positions, 2, bond_length, length * 1.1).deflection));
    EXPECT_TRUE(std::isnan(read_mark(positions, 2, bond_length, -1e-3).deflection));
    EXPECT_EQ(read_mark(positions, 2, bond_length, -1e-3).derivative(positions, 2), 0.0);
}

TEST(CurveReading, ErrorOnCantileverModesStaysBelowTheStatedBound) {
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
            largest = std::max(largest,
                               std::abs(read_row(positions, 2, height).deflection - mode(height)));
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
    std::vector<double> rates;
    const auto values = resampled_in_time(sample_times, table, times, &rates);
    for (std::size_t i = 0; i < times.size(); ++i) {
        const double t = times[i];
        EXPECT_NEAR(values[2 * i], cubic(t), 1e-13);
        EXPECT_NEAR(values[2 * i + 1], -cubic(t), 1e-13);
        EXPECT_NEAR(rates[2 * i], 2.0 - 6.0 * t + 12.0 * t * t, 1e-12);
    }
}

TEST(TimeStencil, HoldsTheStemBeforeTheReleaseAndSeesNothingAfterTheLastSample) {
    const std::vector<double> sample_times{0.0, 0.1, 0.2, 0.3, 0.4};
    const std::vector<double> table{5.0, 4.0, 2.0, -1.0, -2.0};
    std::vector<double> rates;
    const auto values =
        resampled_in_time(sample_times, table, std::vector{-0.5, 0.0, 0.4 + 1e-11, 0.41}, &rates);
    EXPECT_EQ(values[0], 5.0);
    EXPECT_EQ(rates[0], 0.0);
    EXPECT_EQ(values[1], 5.0);
    EXPECT_NEAR(values[2], -2.0, 1e-9);
    EXPECT_TRUE(std::isnan(values[3]));
    EXPECT_TRUE(std::isnan(rates[3]));
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
