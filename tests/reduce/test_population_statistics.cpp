// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/population_statistics.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace {

using namespace culm::reduce;

TEST(SampleSummary, HasTheNumbersOfATextbookExample) {
    const std::vector<double> values{2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0};
    const SampleSummary summary = summarise(values);
    EXPECT_EQ(summary.count, 8U);
    EXPECT_DOUBLE_EQ(summary.mean, 5.0);
    EXPECT_DOUBLE_EQ(summary.standard_deviation, std::sqrt(32.0 / 7.0));
    EXPECT_DOUBLE_EQ(summary.median, 4.5);
    EXPECT_DOUBLE_EQ(summary.central_90_percent.lower, 2.7); // 2 + 0.35 (4 - 2)
    EXPECT_EQ(summary.lowest, 2.0);
    EXPECT_EQ(summary.highest, 9.0);
    // t(0.975, 7) = 2.3646, chi2(0.025, 7) = 1.6899, chi2(0.975, 7) = 16.0128 from tables.
    EXPECT_NEAR(summary.mean_interval.upper, 5.0 + 2.3646 * std::sqrt(32.0 / 7.0 / 8.0), 1e-4);
    EXPECT_NEAR(summary.standard_deviation_interval.lower, std::sqrt(32.0 / 16.0128), 1e-5);
    EXPECT_NEAR(summary.standard_deviation_interval.upper, std::sqrt(32.0 / 1.6899), 1e-3);
}

TEST(SampleSummary, HasNoSpreadForOneOrNoValue) {
    const std::vector<double> one{3.0};
    EXPECT_EQ(summarise(one).mean, 3.0);
    EXPECT_TRUE(std::isnan(summarise(one).standard_deviation));
    EXPECT_TRUE(std::isnan(summarise({}).mean));
}

TEST(LineFit, FindsSlopeAndItsErrorWithAndWithoutWeights) {
    const std::vector<double> x{1.0, 2.0, 3.0, 4.0};
    const std::vector<double> y{2.1, 3.9, 6.2, 7.8};
    const LineFit line = fit_line(x, y);
    EXPECT_NEAR(line.slope, 1.94, 1e-12);
    EXPECT_NEAR(line.intercept, 0.15, 1e-12);
    // RSS = 0.082, Sxx = 5, two degrees of freedom.
    EXPECT_NEAR(line.slope_error, std::sqrt(0.082 / 2.0 / 5.0), 1e-12);
    // A weight of two equals a repeated point, except for the degrees of freedom.
    const LineFit weighted = fit_line(x, y, std::vector{1.0, 1.0, 1.0, 2.0});
    const LineFit doubled =
        fit_line(std::vector{1.0, 2.0, 3.0, 4.0, 4.0}, std::vector{2.1, 3.9, 6.2, 7.8, 7.8});
    EXPECT_NEAR(weighted.slope, doubled.slope, 1e-12);
    EXPECT_EQ(fit_line(std::vector{1.0, 1.0, 1.0}, std::vector{1.0, 2.0, 3.0}).count, 0U);
    EXPECT_EQ(fit_line(std::vector{1.0, 2.0}, std::vector{1.0, 2.0}).count, 0U);
}

TEST(Holm, AdjustsAsInHisPaper) {
    const std::vector<double> adjusted = holm_adjusted(std::vector{0.01, 0.04, 0.03, 0.005});
    EXPECT_NEAR(adjusted[3], 0.02, 1e-12);
    EXPECT_NEAR(adjusted[0], 0.03, 1e-12);
    EXPECT_NEAR(adjusted[2], 0.06, 1e-12);
    EXPECT_NEAR(adjusted[1], 0.06, 1e-12);
}

TEST(Holm, KeepsFalseAlarmsOfManySlopesBelowFivePercent) {
    std::mt19937 random(5);
    std::normal_distribution<double> noise;
    int alarms = 0;
    constexpr int experiments = 400;
    for (int i = 0; i < experiments; ++i) {
        std::vector<double> p_values;
        for (int stem = 0; stem < 29; ++stem) {
            std::vector<double> x;
            std::vector<double> y;
            for (int j = 0; j < 10; ++j) {
                x.push_back(0.1 * j);
                y.push_back(noise(random));
            }
            p_values.push_back(fit_line(x, y).p_value);
        }
        bool is_alarm = false;
        for (const double p : holm_adjusted(p_values))
            is_alarm = is_alarm || p < 0.05;
        alarms += is_alarm ? 1 : 0;
    }
    // 20 expected, standard deviation 4.4; without the adjustment 310.
    EXPECT_LT(alarms, 36);
    EXPECT_GT(alarms, 4);
}

} // namespace
