// SPDX-License-Identifier: BSD-3-Clause
#include "integrate/history_sampler.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace culm::integrate {
namespace {

/// Feeds a two-sphere chain whose tip swings as sin(ωt) at the given times, and returns the largest
/// error of the samples.
double worst_error(const std::vector<double>& times, double omega, double interval,
                   std::size_t count, std::size_t& emitted) {
    const physics::ChainLayout<2> layout(2);
    double worst = 0.0;
    HistorySampler<2> sampler(layout, 1, 1, interval, count, true,
                              [&](std::size_t k, const HistorySampler<2>::Rates& rates) {
                                  const double t = static_cast<double>(k) * interval;
                                  worst =
                                      std::max(worst, std::abs(rates[0][1] - std::sin(omega * t)));
                              });
    for (const double t : times) {
        std::vector<double> state(layout.size(), 0.0);
        physics::SphereState<2, double> tip{
            {{1.0, std::sin(omega * t)}}, {{0.0, omega * std::cos(omega * t)}}, {{0.0}}};
        layout.set_sphere(state.data(), 1, tip);
        sampler.observe(t, state);
    }
    sampler.finish();
    emitted = sampler.emitted();
    return worst;
}

std::vector<double> uniform_times(int steps) {
    std::vector<double> times;
    for (int i = 0; i <= steps; ++i)
        times.push_back(static_cast<double>(i) / steps);
    return times;
}

TEST(HistorySampler, InterpolatesAtSixthOrder) {
    std::size_t emitted = 0;
    const double omega = 2 * 3.14159265358979323846;
    const double coarse = worst_error(uniform_times(20), omega, 1.0 / 333, 334, emitted);
    EXPECT_EQ(emitted, 334U);
    const double fine = worst_error(uniform_times(40), omega, 1.0 / 333, 334, emitted);
    EXPECT_NEAR(std::log2(coarse / fine), 6.0, 0.3);
    EXPECT_LT(coarse, 2e-7); // (2π/20)^6 · 1.5e-4 = 1.4e-7
}

TEST(HistorySampler, StaysAccurateWhereStepsGrowSuddenly) {
    std::vector<double> times{0.0, 1e-9, 1e-7, 1e-5, 1e-3};
    for (int i = 1; i <= 100; ++i)
        times.push_back(i / 100.0);
    std::size_t emitted = 0;
    // A cubic over a step of 1/100 of a period: (2π/100)⁴/384 = 4e-8.
    EXPECT_LT(worst_error(times, 2 * 3.14159265358979323846, 1e-3, 1001, emitted), 1e-7);
    EXPECT_EQ(emitted, 1001U);
}

TEST(HistorySampler, EmitsEverySampleOfTwoSteps) {
    std::size_t emitted = 0;
    // One cubic over a third of a radian: 0.33⁴/384.
    EXPECT_LT(worst_error({0.0, 0.33}, 1.0, 0.11, 4, emitted), 4e-5);
    EXPECT_EQ(emitted, 4U);
}

} // namespace
} // namespace culm::integrate
