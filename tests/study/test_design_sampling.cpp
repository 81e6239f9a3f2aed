// SPDX-License-Identifier: BSD-3-Clause
// Latin hypercubes and Sobol sequences in the unit cube.
#include "study/design/sampling.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include <gtest/gtest.h>

namespace culm::study {
namespace {

/// A coordinate as draw_unit_samples() makes it if no criterion changes the strata.
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
    EXPECT_EQ(sobol_points(5, 3), expected);
}

TEST(Sobol, RotationKeepsTheOpenUnitInterval) {
    for (int i = 0; i < 1000; ++i) {
        const double u = rotated(0.001 + i * 0.000998, {3, "length_mm", 2});
        EXPECT_GT(u, 0.0);
        EXPECT_LT(u, 1.0);
    }
    EXPECT_NE(rotated(0.5, {3, "length_mm", 1}), rotated(0.5, {3, "length_mm", 2}));
}

} // namespace
} // namespace culm::study
