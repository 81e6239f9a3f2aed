// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/population.hpp"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace {

using namespace culm;

std::vector<double> normal_sample(std::size_t count, unsigned seed) {
    std::mt19937 generator(seed);
    std::normal_distribution<double> normal(10.0, 2.0);
    std::vector<double> values(count);
    for (double& value : values)
        value = normal(generator);
    return values;
}

TEST(CentralRange, EndsAtTheQuantilesOfTheSample) {
    const std::vector<double> values{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};
    const calibrate::CentralRange found = calibrate::central_range(values);
    EXPECT_DOUBLE_EQ(found.sample.central_90_percent.lower, 1.5);
    EXPECT_DOUBLE_EQ(found.sample.central_90_percent.upper, 10.5);
    EXPECT_LE(found.lower_interval.lower, 1.5);
    EXPECT_GE(found.lower_interval.upper, 1.5);
}

TEST(CentralRange, IsTheSameEveryTime) {
    const std::vector<double> values = normal_sample(29, 1);
    const auto a = calibrate::central_range(values);
    const auto b = calibrate::central_range(values);
    EXPECT_EQ(a.lower_interval.lower, b.lower_interval.lower);
    EXPECT_EQ(a.upper_interval.upper, b.upper_interval.upper);
}

TEST(CentralRange, HasIntervalsThatUsuallyCoverTheTrueQuantile) {
    const double truth = 10.0 - 1.644854 * 2.0;
    int covered = 0;
    constexpr int samples = 200;
    for (unsigned seed = 1; seed <= samples; ++seed) {
        const auto found = calibrate::central_range(normal_sample(100, seed), 400);
        covered += found.lower_interval.lower <= truth && truth <= found.lower_interval.upper;
    }
    // Percentile intervals of an outer quantile of 100 values cover some 92 … 95 %; four standard
    // deviations of 200 trials are 7 %.
    EXPECT_GT(covered, 170);
    EXPECT_LT(covered, 200);
}

} // namespace
