// SPDX-License-Identifier: BSD-3-Clause
// Latin hypercubes and Sobol sequences, scrambled ones too, in the unit cube.
#include "study/design/sampling.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace culm::study {
namespace {

/// A coordinate as make_design() draws it.
std::vector<double> coordinate(const SampleKey& key, std::int64_t points) {
    return places_in_strata(key, latin_hypercube_strata(key, points));
}

TEST(LatinHypercube, EveryStratumHoldsOnePoint) {
    for (const std::int64_t points : {1, 2, 7, 1000}) {
        std::set<std::int64_t> strata;
        for (const double u : coordinate({3, "length_mm", 0}, points))
            strata.insert(static_cast<std::int64_t>(std::floor(u * static_cast<double>(points))));
        EXPECT_EQ(static_cast<std::int64_t>(strata.size()), points);
        EXPECT_EQ(*strata.begin(), 0);
        EXPECT_EQ(*strata.rbegin(), points - 1);
    }
}

TEST(LatinHypercube, FactorsAreNotCorrelated) {
    constexpr std::int64_t points = 10'000;
    const auto a = coordinate({3, "length_mm", 0}, points);
    const auto b = coordinate({3, "bond_damping", 0}, points);
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i)
        sum += (a[i] - 0.5) * (b[i] - 0.5);
    // The correlation of independent permutations has the standard deviation 1/√(n − 1) = 0.01;
    // the tolerance is five times this. The seed is fixed.
    EXPECT_LT(std::abs(12.0 * sum / static_cast<double>(points)), 0.05);
}

TEST(LatinHypercube, SeedFactorAndReplicateSelectThePermutation) {
    const auto reference = coordinate({3, "length_mm", 0}, 50);
    EXPECT_EQ(coordinate({3, "length_mm", 0}, 50), reference);
    EXPECT_NE(coordinate({4, "length_mm", 0}, 50), reference);
    EXPECT_NE(coordinate({3, "length_mm", 1}, 50), reference);
    EXPECT_NE(coordinate({3, "bond_damping", 0}, 50), reference);
}

TEST(Sobol, TheFirstPointsAreThePublishedOnes) {
    // Joe & Kuo (2008), new-joe-kuo-6.21201, in Gray code order after the origin.
    const std::vector<double> expected{0.5,   0.5,   0.5,   //
                                       0.75,  0.25,  0.25,  //
                                       0.25,  0.75,  0.75,  //
                                       0.375, 0.375, 0.625, //
                                       0.875, 0.875, 0.125};
    std::vector<double> found;
    for (const std::uint64_t digits : sobol_digits(6, 3))
        found.push_back(open_unit_interval(digits));
    found.erase(found.begin(), found.begin() + 3);
    EXPECT_EQ(found, expected);
}

TEST(Sobol, RotationKeepsTheOpenUnitInterval) {
    for (int i = 0; i < 1000; ++i) {
        const double u = rotated(0.001 + i * 0.000998, {3, "length_mm", 2});
        EXPECT_GT(u, 0.0);
        EXPECT_LT(u, 1.0);
    }
    EXPECT_NE(rotated(0.5, {3, "length_mm", 1}), rotated(0.5, {3, "length_mm", 2}));
}

/// Scrambled points of `dimensions` coordinates: (dimensions, points).
std::vector<std::vector<double>> scrambled(std::uint64_t seed, std::int64_t points) {
    constexpr std::size_t dimensions = 3;
    const auto digits = sobol_digits(points, dimensions);
    const char* names[dimensions] = {"a", "b", "c"};
    std::vector<std::vector<double>> columns(dimensions);
    for (std::size_t k = 0; k < dimensions; ++k) {
        const DigitScrambler scrambler(Scrambling::Owen, {seed, names[k], 0}, points);
        for (std::int64_t i = 0; i < points; ++i)
            columns[k].push_back(
                open_unit_interval(scrambler(digits[std::size_t(i) * dimensions + k])));
    }
    return columns;
}

TEST(Scrambling, KeepsTheDigitalNet) {
    const auto columns = scrambled(3, 256);
    // The first two dimensions are a (0, 8, 2)-net: each of the 256 boxes of any shape
    // 2^-a × 2^-(8−a) holds one point.
    for (int a = 0; a <= 8; ++a) {
        std::set<std::pair<int, int>> boxes;
        for (std::size_t i = 0; i < 256; ++i)
            boxes.emplace(int(columns[0][i] * std::ldexp(1.0, a)),
                          int(columns[1][i] * std::ldexp(1.0, 8 - a)));
        EXPECT_EQ(boxes.size(), 256U) << a;
    }
}

TEST(Scrambling, MakesEveryPointUniform) {
    // The first point has the mean 1/2 over many seeds, with a standard deviation of 0.289/√2000.
    // The tolerance is five times this. Without scrambling the point is the origin.
    double sum = 0.0;
    for (std::uint64_t seed = 0; seed < 2000; ++seed)
        sum += scrambled(seed, 1)[0][0];
    EXPECT_NEAR(sum / 2000.0, 0.5, 5.0 * 0.289 / std::sqrt(2000.0));
}

TEST(Scrambling, IntegratesSmoothFunctionsBetterThanIndependentPoints) {
    // ∫ Π (1 + (u − 1/2)) = 1; the root mean square error of Owen's scrambling falls as n^-1.5.
    const auto error = [](std::int64_t points) {
        double squares = 0.0;
        constexpr int seeds = 40;
        for (std::uint64_t seed = 0; seed < seeds; ++seed) {
            const auto columns = scrambled(seed, points);
            double sum = 0.0;
            for (std::size_t i = 0; i < std::size_t(points); ++i)
                sum += (0.5 + columns[0][i]) * (0.5 + columns[1][i]) * (0.5 + columns[2][i]);
            squares += std::pow(sum / static_cast<double>(points) - 1.0, 2) / seeds;
        }
        return std::sqrt(squares);
    };
    // With 16 times the points the theory gives a factor of 64; independent points give 4.
    EXPECT_GT(error(64) / error(1024), 25.0);
}

} // namespace
} // namespace culm::study
