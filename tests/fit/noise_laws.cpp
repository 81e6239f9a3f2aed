// SPDX-License-Identifier: BSD-3-Clause
// Estimates from noise whose law is known, because it is drawn here.
#include "fit/noise/noise_laws.hpp"

#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <random>
#include <vector>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

namespace culm::tests {
namespace {

std::vector<double> gaussian(std::size_t count, unsigned seed) {
    std::mt19937 dice(seed);
    std::normal_distribution<double> normal;
    std::vector<double> values(count);
    for (double& value : values)
        value = normal(dice);
    return values;
}

TEST(Tails, AreFoundForStudentsT) {
    std::mt19937 dice(1);
    std::student_t_distribution<double> law(3.0);
    std::vector<double> values(5000);
    for (double& value : values)
        value = 0.5 * law(dice);
    const fit::Tails tails = fit::tails_of(values);
    EXPECT_TRUE(tails.is_heavy);
    EXPECT_GE(tails.degrees, 2.5);
    EXPECT_LE(tails.degrees, 4.0);
    EXPECT_NEAR(tails.scale, 0.5, 0.03);
    EXPECT_FALSE(fit::tails_of(gaussian(5000, 2)).is_heavy);
}

/// Fourier coefficients of rows that share the part `common` of their variance, with the spectrum
/// of a first-order autoregression.
Eigen::MatrixXcd coefficients(double common, double correlation, Eigen::Index bins,
                              Eigen::Index rows, unsigned seed) {
    std::mt19937 dice(seed);
    std::normal_distribution<double> normal(0.0, std::sqrt(0.5));
    const auto drawn = [&] { return std::complex<double>(normal(dice), normal(dice)); };
    Eigen::MatrixXcd out(bins, rows);
    for (Eigen::Index k = 0; k < bins; ++k) {
        const double size = std::sqrt(fit::spectrum_of(correlation, {k + 1}, 2 * bins)(0));
        const std::complex<double> together = drawn();
        for (Eigen::Index j = 0; j < rows; ++j)
            out(k, j) = size * (std::sqrt(common) * together + std::sqrt(1.0 - common) * drawn());
    }
    return out;
}

TEST(TimingNoise, IsFoundFromItsGrowthWithTheRate) {
    const std::vector<double> first = gaussian(4000, 5);
    const std::vector<double> second = gaussian(4000, 6);
    std::vector<double> errors;
    std::vector<double> rates;
    for (std::size_t i = 0; i < first.size(); ++i) {
        rates.push_back(1000.0 * std::cos(0.1 * static_cast<double>(i)));
        errors.push_back(0.3 * first[i] + 5e-4 * rates.back() * second[i]);
    }
    const fit::TimingNoise found = fit::timing_noise_of(errors, rates);
    EXPECT_NEAR(found.deviation, 0.3, 0.02);
    EXPECT_NEAR(found.time_uncertainty, 5e-4, 0.3e-4);
    EXPECT_EQ(fit::timing_noise_of(first, rates).time_uncertainty, 0.0);
    EXPECT_EQ(fit::timing_noise_of({}, {}).time_uncertainty, 0.0);
}

TEST(CommonShare, IsFound) {
    EXPECT_EQ(fit::common_share_of(coefficients(0.0, 0.0, 100, 14, 6)), 0.0);
    EXPECT_NEAR(fit::common_share_of(coefficients(0.5, 0.0, 100, 14, 7)), 0.5, 0.1);
    EXPECT_GT(fit::common_share_of(coefficients(1.0, 0.0, 100, 14, 8)), 0.95);
    // Eigenvalues 7.5 and thirteen times 0.5.
    EXPECT_NEAR(fit::independent_rows(0.5, 14.0), 196.0 / (7.5 * 7.5 + 13.0 * 0.25), 1e-12);
}

// The law of Wiener and Khinchin: the spectrum is the Fourier sum of the covariances ρᵏ.
TEST(SlowNoise, HasTheSpectrumOfItsCovariances) {
    constexpr double correlation = 0.7;
    constexpr Eigen::Index frames = 64;
    for (const Eigen::Index bin : {1, 10, 30}) {
        double sum = 1.0;
        for (int lag = 1; lag < 200; ++lag)
            sum += 2.0 * std::pow(correlation, lag) *
                   std::cos(2.0 * std::numbers::pi * lag * static_cast<double>(bin) / frames);
        EXPECT_NEAR(fit::spectrum_of(correlation, {bin}, frames)(0), sum, 1e-12) << bin;
    }
}

// Rows with common errors scatter about the spectrum by more than independent ones. Treated as
// independent they would appear to be correlated by 0.98.
TEST(SlowNoise, HasItsCorrelationForRowsWithCommonErrors) {
    constexpr Eigen::Index bins = 94;
    const Eigen::MatrixXcd found = coefficients(0.5, 0.9, bins, 14, 9);
    std::vector<Eigen::Index> at;
    for (Eigen::Index k = 1; k <= bins; ++k)
        at.push_back(k);
    const fit::SlowNoise slow = fit::slow_noise_of(found.cwiseAbs2().rowwise().mean(),
                                                   fit::independent_rows(0.5, 14.0), at, 2 * bins);
    EXPECT_NEAR(slow.correlation, 0.9, 0.05);
    // The record determines the changes from frame to frame better than their slow sum.
    EXPECT_NEAR(slow.variance * (1.0 - std::pow(slow.correlation, 2)), 0.19, 0.04);
}

TEST(SlowNoise, IsAbsentFromWhiteNoise) {
    std::mt19937 dice(12);
    std::exponential_distribution<double> law;
    Eigen::ArrayXd power(100);
    std::vector<Eigen::Index> at;
    for (Eigen::Index k = 0; k < power.size(); ++k) {
        power(k) = law(dice);
        at.push_back(k + 1);
    }
    EXPECT_EQ(fit::slow_noise_of(power, 1.0, at, 202).correlation, 0.0);
}

} // namespace
} // namespace culm::tests
