// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/population.hpp"

#include <optional>
#include <vector>

#include <gtest/gtest.h>

namespace {

using namespace culm;

TEST(Population, HasTheQuantilesOfItsStems) {
    std::vector<calibrate::StemNumbers> stems;
    for (int k = 1; k <= 11; ++k)
        stems.push_back({1e9 * k, 2.0 * k, -0.1 * k, 10.0 * k, k != 3});
    const std::optional<calibrate::Population> found = calibrate::population_of(stems, 4);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->stems, 11U);
    EXPECT_EQ(found->failed, 4U);
    EXPECT_EQ(found->inadequate, 1U);
    EXPECT_DOUBLE_EQ(found->bond_youngs_modulus.central_90_percent.lower, 1.5e9);
    EXPECT_DOUBLE_EQ(found->bond_youngs_modulus.central_90_percent.upper, 10.5e9);
    EXPECT_DOUBLE_EQ(found->bond_damping.mean, 12.0);
    EXPECT_DOUBLE_EQ(found->decay_per_cycle.lowest, -1.1);
    EXPECT_DOUBLE_EQ(found->frequency.median, 60.0);
}

TEST(Population, NeedsTwoStems) {
    const std::vector<calibrate::StemNumbers> one(1);
    EXPECT_FALSE(calibrate::population_of(one, 0));
}

} // namespace
