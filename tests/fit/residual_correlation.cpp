// SPDX-License-Identifier: BSD-3-Clause
#include "fit/solve/residual_statistics.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace culm::tests {
namespace {

using fit::effective_degrees_of_freedom;

/// First-order autoregressive columns of unit variance.
Eigen::MatrixXd correlated_noise(Eigen::Index frames, Eigen::Index rows, double correlation,
                                 unsigned seed) {
    std::mt19937 generator(seed);
    std::normal_distribution<double> normal;
    Eigen::MatrixXd noise(frames, rows);
    for (Eigen::Index j = 0; j < rows; ++j) {
        double value = normal(generator);
        for (Eigen::Index i = 0; i < frames; ++i) {
            noise(i, j) = value;
            value = correlation * value +
                    std::sqrt(1.0 - correlation * correlation) * normal(generator);
        }
    }
    return noise;
}

TEST(EffectiveDegreesOfFreedom, EqualTheNumberOfReadingsForWhiteNoise) {
    double sum = 0.0;
    for (unsigned seed = 0; seed < 20; ++seed)
        sum += effective_degrees_of_freedom(correlated_noise(400, 9, 0.0, seed), 12);
    // The estimate scatters by a few per cent from table to table, and cannot exceed the number.
    EXPECT_NEAR(sum / 20.0, 3600.0, 0.03 * 3600.0);
}

TEST(EffectiveDegreesOfFreedom, GiveTheVarianceOfTheSumOfSquaresForCorrelatedNoise) {
    const double correlation = 0.8;
    double estimated = 0.0;
    double mean = 0.0;
    double square = 0.0;
    constexpr int tables = 400;
    for (unsigned seed = 0; seed < tables; ++seed) {
        const Eigen::MatrixXd noise = correlated_noise(400, 6, correlation, seed);
        estimated += effective_degrees_of_freedom(noise, 40) / tables;
        mean += noise.squaredNorm() / tables;
        square += std::pow(noise.squaredNorm(), 2) / tables;
    }
    // χ² of ν degrees of freedom times a constant has variance 2 mean²/ν.
    const double true_count = 2.0 * mean * mean / (square - mean * mean);
    // 400 tables determine a variance to 7 %; noisy autocorrelations make the sum low by some 5 %.
    EXPECT_NEAR(estimated, true_count, 0.2 * true_count);
    EXPECT_LT(estimated, 0.35 * 2400.0);
}

TEST(EffectiveDegreesOfFreedom, AreThoseOfOneRowForEqualRows) {
    const Eigen::MatrixXd one = correlated_noise(500, 1, 0.0, 3);
    // One row has 500 readings and equal rows add none; the estimate scatters by 5 %.
    EXPECT_NEAR(effective_degrees_of_freedom(one.replicate(1, 8), 12), 500.0, 25.0);
}

TEST(ChiSquaredTail, AgreesWithTablesAndTakesFractions) {
    EXPECT_NEAR(reduce::chi_squared_p_value(18.307, 10.0), 0.05, 1e-5); // five figures printed
    EXPECT_NEAR(reduce::chi_squared_p_value(6.635, 1.0), 0.01, 1e-5);
    EXPECT_GT(reduce::chi_squared_p_value(10.0, 10.5), reduce::chi_squared_p_value(10.0, 10.0));
}

} // namespace
} // namespace culm::tests
