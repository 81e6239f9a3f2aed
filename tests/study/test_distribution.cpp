// SPDX-License-Identifier: BSD-3-Clause
// Quantiles and moments of the truncated distributions.
#include "study/design/factor.hpp"
#include "study/design/sampling.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace culm::study {
namespace {

struct Moments {
    double mean = 0.0;
    double sd = 0.0;
};

constexpr int draws = 100'000;

Moments sampled(const Distribution& distribution) {
    double sum = 0.0;
    double squares = 0.0;
    for (int i = 0; i < draws; ++i) {
        const RandomKey key{5, RandomPurpose::Draw, 1, 0, static_cast<std::uint64_t>(i)};
        const double x = distribution.quantile(random_uniform(key));
        sum += x;
        squares += x * x;
    }
    const double mean = sum / draws;
    return {mean, std::sqrt(squares / draws - mean * mean)};
}

// The standard error of a sample's mean is sd/√n, that of its sd about sd √((kurtosis − 1)/(4n)).
// Five standard errors are exceeded once in two million seeds. The seed is fixed.
constexpr double standard_errors = 5.0;

void expect_moments(const Distribution& distribution, Moments expected, double kurtosis) {
    const Moments found = sampled(distribution);
    EXPECT_NEAR(found.mean, expected.mean, standard_errors * expected.sd / std::sqrt(draws));
    EXPECT_NEAR(found.sd, expected.sd,
                standard_errors * expected.sd * std::sqrt((kurtosis - 1.0) / (4.0 * draws)));
}

TEST(Distribution, WideNormalHasItsMoments) {
    expect_moments(Distribution::normal(156.0, 4.5, 100.0, 200.0), {156.0, 4.5}, 3.0);
}

TEST(Distribution, HalfNormalHasItsMoments) {
    // Truncated at its mean: mean σ √(2/π), variance σ² (1 − 2/π), kurtosis 3.869.
    const double sd = 2.0;
    const double pi = std::acos(-1.0);
    expect_moments(Distribution::normal(0.0, sd, 0.0, 100.0),
                   {sd * std::sqrt(2.0 / pi), sd * std::sqrt(1.0 - 2.0 / pi)}, 3.869);
}

TEST(Distribution, LognormalHasTheMomentsOfTheQuantityItself) {
    // mean 2, sd 0.5: σ² = ln(1 + 1/16); kurtosis e^{4σ²} + 2e^{3σ²} + 3e^{2σ²} − 3 = 4.1.
    expect_moments(Distribution::lognormal(2.0, 0.5, 0.0, 1e6), {2.0, 0.5}, 4.1);
}

TEST(Distribution, UniformHasItsMoments) {
    expect_moments(Distribution::uniform(-1.0, 3.0), {1.0, 4.0 / std::sqrt(12.0)}, 1.8);
}

TEST(Distribution, LogUniformHasTheGeometricMeanAsMedian) {
    EXPECT_NEAR(Distribution::log_uniform(1.0, 100.0).quantile(0.5), 10.0,
                1e-13); // rounding of exp
}

TEST(Distribution, QuantilesAreKnownValues) {
    // 0.975 quantile of the standard normal, from tables; the truncation at ±40 sd changes nothing.
    EXPECT_NEAR(Distribution::normal(0.0, 1.0, -40.0, 40.0).quantile(0.975), 1.959963984540054,
                1e-14);
    EXPECT_EQ(Distribution::uniform(2.0, 6.0).quantile(0.25), 3.0);
}

TEST(Distribution, TheUpperTailIsAsAccurateAsTheLower) {
    const Distribution low = Distribution::normal(0.0, 1.0, -9.0, -8.5);
    const Distribution high = Distribution::normal(0.0, 1.0, 8.5, 9.0);
    for (const double u : {0.125, 0.25, 0.5, 0.75}) // 1 − u is exact
        EXPECT_EQ(high.quantile(u), -low.quantile(1.0 - u));
}

TEST(Distribution, QuantilesStayInsideAndIncrease) {
    for (const Distribution& distribution :
         {Distribution::normal(1.0, 2.0, 0.5, 1.5), Distribution::lognormal(1.0, 2.0, 0.5, 1.5),
          Distribution::uniform(0.5, 1.5), Distribution::log_uniform(0.5, 1.5)}) {
        double previous = 0.5;
        for (const double u : {0x1p-54, 0.01, 0.3, 0.6, 0.99, 1.0 - 0x1p-53}) {
            const double x = distribution.quantile(u);
            EXPECT_GE(x, previous) << to_string(distribution.kind()) << " " << u;
            EXPECT_LE(x, 1.5) << to_string(distribution.kind()) << " " << u;
            previous = x;
        }
        EXPECT_GT(previous, 1.49); // the last u is the upper end up to rounding
    }
}

} // namespace
} // namespace culm::study
