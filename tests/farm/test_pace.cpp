// SPDX-License-Identifier: BSD-3-Clause
// The time per unit of cost is learned from timed batches, and later batches replace earlier runs.
#include "farm/pace.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace culm::farm {
namespace {

TEST(Pace, IsUnknownAtFirst) {
    EXPECT_FALSE(Pace().is_known());
}

TEST(Pace, IsTheTimeOverTheCost) {
    Pace pace;
    pace.learn(2.0, 6.0);
    pace.learn(4.0, 12.0);
    EXPECT_TRUE(pace.is_known());
    EXPECT_DOUBLE_EQ(pace.mean(), 3.0);
}

TEST(Pace, AddsATenthWhereBatchesTakeWhatTheyCost) {
    Pace pace;
    for (const double cost : {1.0, 7.0, 30.0})
        pace.learn(cost, 2.0 * cost);
    EXPECT_NEAR(pace.cautious(), 2.2, 1e-6); // the root of a difference of rounded squares
}

TEST(Pace, IsMoreCautiousWhereBatchesScatter) {
    // Two batches of cost 1 that took 1 s and 3 s: mean 2, standard deviation 1.
    Pace pace;
    pace.learn(1.0, 1.0);
    pace.learn(1.0, 3.0);
    EXPECT_DOUBLE_EQ(pace.cautious(), 2.2 + 3.0);
}

TEST(Pace, YieldsToThisRunAfterAnEarlierOne) {
    Pace earlier;
    for (int k = 0; k < 1000; ++k)
        earlier.learn(1.0, 10.0);
    Pace pace = earlier.with_weight_up_to(1.0);
    EXPECT_DOUBLE_EQ(pace.mean(), 10.0);
    EXPECT_NEAR(pace.cautious(), 11.0, 1e-5);
    pace.learn(9.0, 9.0); // a machine ten times as fast
    EXPECT_DOUBLE_EQ(pace.mean(), 1.9);
    EXPECT_EQ(earlier.with_weight_up_to(1e9), earlier) << "a small weight is not increased";
}

TEST(Pace, LearnsNothingFromWorkWithoutCostOrTime) {
    Pace pace;
    pace.learn(0.0, 5.0);
    pace.learn(1.0, std::nan(""));
    EXPECT_FALSE(pace.is_known());
}

} // namespace
} // namespace culm::farm
