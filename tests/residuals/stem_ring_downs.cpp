// SPDX-License-Identifier: BSD-3-Clause
#include "residuals/stem_ring_downs.hpp"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace {

using namespace culm::residuals;
using culm::measure::Measurement;

/// A stem of 0.16 m with ten heights whose decay per cycle changes by `slope` from clamp to tip.
Measurement stem(double decay, double frequency, double slope, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0.0, 5e-5);
    Measurement result;
    result.stem.length = 0.16;
    result.stem.section = culm::measure::CircularSection{2.5e-3, {}};
    result.noise = 5e-5;
    for (int i = 0; i < 300; ++i)
        result.times.push_back(i / 960.0);
    result.deflections.resize(10 * result.times.size());
    for (std::size_t j = 0; j < 10; ++j) {
        const double place = static_cast<double>(j + 1) / 10.0;
        result.heights.push_back(place * result.stem.length);
        const double rate = (decay + slope * place) * frequency;
        for (std::size_t i = 0; i < result.times.size(); ++i)
            result.deflections[10 * i + j] =
                0.02 * place * place * std::exp(rate * result.times[i]) *
                    std::cos(2.0 * std::numbers::pi * frequency * result.times[i]) +
                noise(random);
    }
    return result;
}

TEST(StemRingDowns, MeanOverHeightsIsTheStemsAndItsIntervalHoldsTheTruth) {
    int covered = 0;
    constexpr int experiments = 60;
    for (unsigned seed = 0; seed < experiments; ++seed) {
        const StemRingDowns fit = fit_stem(stem(-0.4, 60.0, 0.0, seed), {});
        EXPECT_NEAR(fit.decay_per_cycle->value, -0.4, 0.004);
        EXPECT_NEAR(fit.frequency->value, 60.0, 0.05);
        EXPECT_NEAR(fit.aspect_ratio, 64.0, 1e-9);
        covered += fit.decay_per_cycle->lower < -0.4 && -0.4 < fit.decay_per_cycle->upper;
    }
    EXPECT_GT(covered, 50); // 57 expected, standard deviation 1.7
}

TEST(StemRingDowns, BandingIsFoundWhereItIsAndOnlyThere) {
    std::vector<StemRingDowns> stems;
    for (unsigned seed = 0; seed < 12; ++seed)
        stems.push_back(fit_stem(stem(-0.4, 60.0, seed == 7 ? -0.1 : 0.0, 500 + seed), {}));
    const PopulationSummary population = summarise_population(stems);
    EXPECT_EQ(population.banded_stems, 1U);
    EXPECT_LT(stems[7].banding_adjusted_p_value, 0.01);
    EXPECT_LT(stems[7].banding->slope_interval.lower, -0.1);
    EXPECT_GT(stems[7].banding->slope_interval.upper, -0.1);
    EXPECT_GT(population.mean_slope_p_value, 0.01);
}

TEST(StemRingDowns, CommonBandingIsFoundInTheMeanOfTheSlopes) {
    std::vector<StemRingDowns> stems;
    for (unsigned seed = 0; seed < 12; ++seed)
        stems.push_back(fit_stem(stem(-0.4, 60.0, -0.02, 900 + seed), {}));
    EXPECT_LT(summarise_population(stems).mean_slope_p_value, 0.001);
}

TEST(StemRingDowns, HeightThatCannotBeFittedIsNamedAndTheOthersCount) {
    Measurement input = stem(-0.4, 60.0, 0.0, 1);
    for (std::size_t i = 0; i < input.times.size(); ++i)
        input.deflections[10 * i + 2] = std::nan("");
    const StemRingDowns fit = fit_stem(input, {});
    EXPECT_FALSE(fit.heights[2].fit);
    EXPECT_NE(fit.heights[2].failure.find("the history has 0"), std::string::npos);
    EXPECT_TRUE(fit.frequency);
    input.deflections.assign(input.deflections.size(), 1e-3);
    std::vector<StemRingDowns> stems{fit_stem(input, {})};
    EXPECT_FALSE(stems[0].frequency);
    EXPECT_EQ(summarise_population(stems).stems, 0U);
}

} // namespace
