// SPDX-License-Identifier: BSD-3-Clause
// What is made of noise whose law is known, because it is drawn here.
#include "fit/model/reading_noise.hpp"

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

double rounded(double value, double step) {
    return step * std::round(value / step);
}

TEST(Tails, OfStudentsTAreFound) {
    std::mt19937 dice(1);
    std::student_t_distribution<double> law(3.0);
    std::vector<double> values(5000);
    for (double& value : values)
        value = 0.5 * law(dice);
    const fit::Tails tails = fit::tails_of(values, 0.0);
    EXPECT_TRUE(tails.is_heavy);
    EXPECT_GE(tails.degrees, 2.5);
    EXPECT_LE(tails.degrees, 4.0);
    EXPECT_NEAR(tails.scale, 0.5, 0.03);
    EXPECT_FALSE(fit::tails_of(gaussian(5000, 2), 0.0).is_heavy);
}

// At rest in the middle of a step 68 % of such readings are 0 and the others a step away.
TEST(Tails, OfRoundedGaussianNoiseAreNone) {
    for (const double step : {2.0, 3.0}) {
        std::vector<double> values = gaussian(5000, 3);
        for (double& value : values)
            value = rounded(value, step);
        const fit::Tails tails = fit::tails_of(values, 0.5 * step);
        EXPECT_FALSE(tails.is_heavy) << step;
        EXPECT_NEAR(tails.scale, 1.0, 0.05) << step;
        EXPECT_TRUE(fit::tails_of(values, 0.0).is_heavy);
    }
}

TEST(Tails, OfRoundedReadingsWithOutliersAreHeavy) {
    std::vector<double> values = gaussian(5000, 4);
    for (std::size_t k = 0; k < values.size(); ++k)
        values[k] = rounded(k % 33 == 0 ? 15.0 * values[k] : values[k], 2.0);
    EXPECT_TRUE(fit::tails_of(values, 1.0).is_heavy);
}

/// (400, 10) of which rows have a share in common, and all are correlated in time.
Eigen::MatrixXd slow(double common, double correlation, unsigned seed) {
    std::mt19937 dice(seed);
    std::normal_distribution<double> normal;
    Eigen::MatrixXd values(400, 10);
    Eigen::VectorXd state = Eigen::VectorXd::Zero(11);
    for (Eigen::Index i = 0; i < values.rows(); ++i) {
        for (double& each : state)
            each = correlation * each + std::sqrt(1.0 - correlation * correlation) * normal(dice);
        values.row(i).setConstant(std::sqrt(common) * state(10));
        values.row(i) += std::sqrt(1.0 - common) * state.head(10).transpose();
    }
    return values;
}

// A tenth of the frames tells the size of noise that is correlated by 0.9 and common to the rows:
// a large error among them counted as ten for each row, and as heavy tails.
TEST(Tails, OfReadingsThatHangTogetherAreNotHeavyByAFewOfThem) {
    int by_readings = 0;
    int together = 0;
    for (unsigned seed = 0; seed < 40; ++seed) {
        const Eigen::MatrixXd values = slow(0.9, 0.9, 100 + seed);
        by_readings +=
            fit::tails_of(std::vector<double>(values.data(), values.data() + values.size()), 0.0)
                .is_heavy;
        together += fit::tails_of(values, 0.0).is_heavy;
    }
    EXPECT_GT(by_readings, 0);
    EXPECT_EQ(together, 0);
    Eigen::MatrixXd outliers = slow(0.5, 0.9, 7);
    for (Eigen::Index k = 0; k < outliers.size(); k += 33)
        outliers(k) += 8.0;
    outliers(5, 3) = std::nan("");
    EXPECT_TRUE(fit::tails_of(outliers, 0.0).is_heavy);
}

TEST(RoundingStep, IsThatOfWhichReadingsAreMultiples) {
    measure::Measurement measurement;
    measurement.heights = {0.1};
    measurement.deflections = gaussian(500, 5);
    EXPECT_EQ(fit::rounding_step(measurement), 0.0);
    for (double& reading : measurement.deflections)
        reading = 0.3 + rounded(reading, 0.07);
    measurement.deflections[7] = std::nan("");
    EXPECT_NEAR(fit::rounding_step(measurement), 0.07, 1e-9);
    EXPECT_EQ(fit::rounding_step({}), 0.0);
}

/// Fourier coefficients of rows of which each has half of its variance in common with all others,
/// and the spectrum of a first-order autoregression of 0.9.
Eigen::MatrixXcd coefficients(double common, Eigen::Index bins, Eigen::Index rows, unsigned seed) {
    std::mt19937 dice(seed);
    std::normal_distribution<double> normal(0.0, std::sqrt(0.5));
    const auto drawn = [&] { return std::complex<double>(normal(dice), normal(dice)); };
    Eigen::MatrixXcd out(bins, rows);
    for (Eigen::Index k = 0; k < bins; ++k) {
        const double turn =
            std::numbers::pi * static_cast<double>(k + 1) / static_cast<double>(bins);
        const double size = std::sqrt(0.19 / (1.81 - 1.8 * std::cos(turn)));
        const std::complex<double> together = drawn();
        for (Eigen::Index j = 0; j < rows; ++j)
            out(k, j) = size * (std::sqrt(common) * together + std::sqrt(1.0 - common) * drawn());
    }
    return out;
}

TEST(IndependentRows, AreCountedWhateverTheirSpectrum) {
    EXPECT_GT(fit::independent_rows(coefficients(0.0, 100, 14, 6)), 13.0);
    // Eigenvalues 7.5 and thirteen times 0.5, for uneven frequencies rather less apart.
    EXPECT_NEAR(fit::independent_rows(coefficients(0.5, 100, 14, 7)), 4.0, 1.0);
    EXPECT_NEAR(fit::independent_rows(coefficients(1.0, 100, 14, 8)), 1.0, 0.1);
}

// Of rows that err together the scatter about the spectrum is large. Taken for that of independent
// ones it made slow noise white (and two of fifteen recordings without an effect inexplicable).
TEST(Series, OfRowsThatErrTogetherHaveTheirCorrelation) {
    constexpr Eigen::Index bins = 94;
    const Eigen::MatrixXcd found = coefficients(0.5, bins, 14, 9);
    std::vector<Eigen::Index> at;
    for (Eigen::Index k = 1; k <= bins; ++k)
        at.push_back(k);
    const measure::NoiseModel::Series series = fit::series_of(
        found.cwiseAbs2().rowwise().mean(), fit::independent_rows(found), at, 2 * bins);
    EXPECT_NEAR(series.correlation, 0.9, 0.05); // of independent rows it would be 0.98
    // Of what is new from frame to frame the record tells more than of the slow sum.
    EXPECT_NEAR(series.variance * (1.0 - std::pow(series.correlation, 2)), 0.19, 0.04);
}

/// Readings of three rows that swing and die down, each with errors that follow from the place.
struct Tracked {
    std::vector<double> values; ///< errors over the noise
    std::vector<double> places;
    std::vector<bool> is_seen;
};
Tracked tracked(double of_place, double of_first_row = 1.0) {
    std::mt19937 dice(11);
    std::normal_distribution<double> normal;
    Tracked out;
    std::vector<double> errors; // (rows, steps): even over a step, as a first approximation of any
    for (int k = 0; k < 3 * 400; ++k)
        errors.push_back(of_place * normal(dice));
    for (int i = 0; i < 600; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
            const double swing = (1.0 + double(j)) * 0.3 * std::exp(-0.003 * i) *
                                 std::cos(0.41 * i + 0.1 * double(j));
            out.places.push_back(swing);
            out.values.push_back(normal(dice) +
                                 (j == 0 ? of_first_row : 1.0) *
                                     errors[j * 400 + std::size_t((swing + 1.0) * 200.0)]);
            out.is_seen.push_back(i != 17);
        }
    return out;
}

TEST(ErrorsOfPlace, AreFoundAndMadeWhite) {
    Tracked with = tracked(0.5);
    const auto found = fit::of_place(with.values, with.places, {}, 3, with.is_seen, 10.0);
    EXPECT_GT(found.variances[0], 0.08);
    EXPECT_LT(found.variances[0], 0.6);
    EXPECT_EQ(found.variances, std::vector<double>(3, found.variances[0])); // rows are alike
    EXPECT_LT(found.length, 0.03);
    EXPECT_EQ(fit::of_place(with.values, with.places, {}, 3, with.is_seen, 0.05).variances,
              std::vector<double>(3, 0.05));
    const auto together = [&](const std::vector<double>& values) { // at one place in all cycles
        double sum = 0.0;
        double count = 0.0;
        for (std::size_t a = 0; a < values.size(); ++a)
            for (std::size_t b = a % 3; b < a; b += 3)
                if (with.is_seen[a] && with.is_seen[b] &&
                    std::abs(with.places[a] - with.places[b]) < 0.001) {
                    sum += values[a] * values[b];
                    count += 1.0;
                }
        return sum / std::sqrt(count); // of white noise: 0 ± 1
    };
    EXPECT_GT(together(with.values), 8.0);
    fit::make_white(fit::place_steps(found, {}, 3, with.is_seen), with.values);
    EXPECT_LT(std::abs(together(with.values)), 4.0);
    const Tracked without = tracked(0.0);
    EXPECT_TRUE(fit::of_place(without.values, without.places, {}, 3, without.is_seen, 10.0)
                    .variances.empty());
}

TEST(ErrorsOfPlace, AreLargerInARowWhoseGroundIsHidden) {
    const Tracked with = tracked(0.4, 4.0);
    const Tracked with_noise_only = tracked(0.0);
    const auto found = fit::of_place(with.values, with.places, {}, 3, with.is_seen, 10.0);
    ASSERT_EQ(found.variances.size(), 3U);
    EXPECT_GT(found.variances[0], 3.0 * found.variances[1]);
    EXPECT_GT(found.variances[0], 3.0 * found.variances[2]);
    // Beside rows that have none.
    Tracked one = tracked(0.1, 5.0);
    for (std::size_t at = 0; at < one.values.size(); ++at)
        if (at % 3 != 0)
            one.values[at] = with_noise_only.values[at];
    const auto alone = fit::of_place(one.values, one.places, {}, 3, one.is_seen, 10.0);
    ASSERT_EQ(alone.variances.size(), 3U);
    EXPECT_GT(alone.variances[0], 0.05);
    EXPECT_EQ(alone.variances[1], 0.0);
    EXPECT_EQ(alone.variances[2], 0.0);
}

// Of such steps, W C Wᵀ = 1 for the covariance C of what they stand for.
TEST(ErrorsOfPlace, AreWhitenedByTheInverseRootOfTheirCovariance) {
    const measure::NoiseModel::OfPlace of_place{{0.3, -0.1, 0.05, 0.3, -0.2}, {0.7}, 0.2};
    const std::vector<double> relative{1.0, 2.0, 0.5, 1.5, 1.0};
    const std::vector<bool> is_seen(5, true);
    Eigen::MatrixXd covariance(5, 5);
    for (Eigen::Index a = 0; a < 5; ++a)
        for (Eigen::Index b = 0; b < 5; ++b) {
            const auto at = [](Eigen::Index k) { return static_cast<std::size_t>(k); };
            covariance(a, b) =
                0.7 * std::exp(-std::abs(of_place.places[at(a)] - of_place.places[at(b)]) / 0.2) +
                (a == b ? relative[at(a)] * relative[at(a)] : 0.0);
        }
    Eigen::MatrixXd white = covariance.llt().matrixL();
    const auto steps = fit::place_steps(of_place, relative, 1, is_seen);
    for (Eigen::Index k = 0; k < 5; ++k)
        fit::make_white(steps, {white.col(k).data(), 5});
    EXPECT_LT((white * white.transpose() - Eigen::MatrixXd::Identity(5, 5)).cwiseAbs().maxCoeff(),
              1e-12);
}

} // namespace
} // namespace culm::tests
