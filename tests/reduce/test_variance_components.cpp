// SPDX-License-Identifier: BSD-3-Clause
// Variance between and within stems: a textbook example, coverage of the intervals, and samples
// that do not determine it.
#include "reduce/population_statistics.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace culm::reduce {
namespace {

/// Stems of a normal population; tests of each stem scatter about its own value.
std::vector<StemTests> simulated(std::size_t stems, std::size_t tests, double sd_between,
                                 double sd_within, std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    std::vector<StemTests> sample(stems);
    for (StemTests& stem : sample) {
        const double own = 3.0 + sd_between * normal(random);
        for (std::size_t k = 0; k < tests; ++k)
            stem.values.push_back(own + sd_within * normal(random));
    }
    return sample;
}

TEST(VarianceComponents, MatchTheHandWorkedTableOfThreeStems) {
    // Means 2, 5, 8 with tests ±1: MS within = 3·2/3 = 2, MS between = 2·9 = 18.
    const std::vector<StemTests> stems{{0, {1, 3}}, {0, {4, 6}}, {0, {7, 9}}};
    const VarianceComponents c = variance_components(stems);
    EXPECT_DOUBLE_EQ(c.within.variance, 2.0);
    EXPECT_DOUBLE_EQ(c.between.variance, 8.0);
    EXPECT_DOUBLE_EQ(c.f_statistic, 9.0);
    EXPECT_DOUBLE_EQ(c.intraclass_correlation.value, 0.8);
    EXPECT_EQ(c.between.degrees_of_freedom, 2U);
    EXPECT_EQ(c.within.degrees_of_freedom, 3U);
    // χ² quantiles with 3 degrees of freedom (tables): 9.3484 and 0.21580; sum of squares 6.
    EXPECT_NEAR(c.within.interval.lower, 6.0 / 9.3484, 1e-4);
    EXPECT_NEAR(c.within.interval.upper, 6.0 / 0.21580, 1e-3 * 27.8);
    // F quantiles (2, 3) (tables): 16.0441 and 1/39.1655.
    EXPECT_NEAR(c.intraclass_correlation.interval.upper, (9 * 39.1655 - 1) / (9 * 39.1655 + 1),
                1e-6);
    EXPECT_EQ(c.intraclass_correlation.interval.lower, 0.0);
}

TEST(VarianceComponents, StrataAreNotComparedWithEachOther) {
    const std::vector<StemTests> stems{{0, {1, 3}},     {0, {4, 6}},     {0, {7, 9}},
                                       {1, {101, 103}}, {1, {104, 106}}, {1, {107, 109}}};
    const VarianceComponents c = variance_components(stems);
    EXPECT_DOUBLE_EQ(c.between.variance, 8.0);
    EXPECT_EQ(c.between.degrees_of_freedom, 4U);
}

TEST(VarianceComponents, IntervalsCoverTheTruthInNineteenOfTwentySamples) {
    std::mt19937_64 random(2019);
    constexpr int samples = 2000;
    const double truths[][2] = {{1.0, 0.5}, {1.0, 2.0}, {0.2, 1.0}};
    for (const auto& truth : truths) {
        const double between = truth[0] * truth[0];
        const double within = truth[1] * truth[1];
        int covers_between = 0;
        int covers_within = 0;
        int covers_share = 0;
        for (int k = 0; k < samples; ++k) {
            const auto c = variance_components(simulated(20, 4, truth[0], truth[1], random));
            const auto covers = [](const Bounds& b, double x) {
                return b.lower <= x && x <= b.upper;
            };
            covers_between += covers(c.between.interval, between);
            covers_within += covers(c.within.interval, within);
            covers_share += covers(c.intraclass_correlation.interval, between / (between + within));
        }
        // 95 % of 2000 with a standard deviation of 0.5 %; four of them. The modified large-sample
        // interval is an approximation that may cover some more (Burdick & Graybill 1992: 94 to
        // 97 %).
        EXPECT_NEAR(covers_within, 1900, 40) << truth[0];
        EXPECT_NEAR(covers_share, 1900, 40) << truth[0];
        EXPECT_GE(covers_between, 1860) << truth[0];
        EXPECT_LE(covers_between, 1960) << truth[0];
    }
}

TEST(VarianceComponents, EstimatesOfAdditiveEffectsAreUnbiasedWithUnequalNumbersOfTests) {
    std::mt19937_64 random(7);
    double between = 0.0;
    double within = 0.0;
    constexpr int samples = 1000;
    for (int k = 0; k < samples; ++k) {
        auto stems = simulated(30, 5, 2.0, 1.0, random);
        for (std::size_t s = 0; s < stems.size(); s += 2)
            stems[s].values.resize(2);
        const auto c = variance_components(stems);
        between += c.between.variance / samples;
        within += c.within.variance / samples;
    }
    // The variances of one sample's estimates are some 1.2² and 0.16²; of the mean of 1000, 0.037
    // and 0.005. Four of them.
    EXPECT_NEAR(between, 4.0, 0.15);
    EXPECT_NEAR(within, 1.0, 0.02);
}

TEST(VarianceComponents, AreUndefinedWhereTheSampleDoesNotDetermineThem) {
    const auto once = variance_components(std::vector<StemTests>{{0, {1}}, {0, {2}}});
    EXPECT_TRUE(std::isnan(once.within.variance));
    EXPECT_TRUE(std::isnan(once.between.variance));
    EXPECT_EQ(once.reason, "no stem was tested twice");
    const auto lone = variance_components(std::vector<StemTests>{{0, {1, 2}}, {1, {3, 4}}});
    EXPECT_DOUBLE_EQ(lone.within.variance, 0.5);
    EXPECT_TRUE(std::isnan(lone.between.variance));
    EXPECT_EQ(lone.reason, "no two stems are of the same design point");
    const auto exact = variance_components(std::vector<StemTests>{{0, {1, 1}}, {0, {3, 3}}});
    EXPECT_EQ(exact.within.variance, 0.0);
    EXPECT_DOUBLE_EQ(exact.between.variance, 2.0);
}

} // namespace
} // namespace culm::reduce
