// SPDX-License-Identifier: BSD-3-Clause
// Shares of the variance against closed forms: linear and quadratic laws, scatter, groups, levels.
#include "core/error.hpp"
#include "reduce/variance_shares.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace culm::reduce {
namespace {

using Eigen::MatrixXd;

MatrixXd uniform(Eigen::Index points, std::mt19937_64& random) {
    std::uniform_real_distribution<double> draw(-1.0, 1.0);
    return MatrixXd::NullaryExpr(points, 1, [&] { return draw(random); });
}

MatrixXd normal(Eigen::Index points, std::mt19937_64& random) {
    std::normal_distribution<double> draw;
    return MatrixXd::NullaryExpr(points, 1, [&] { return draw(random); });
}

double standard_error(const Share& share) {
    return 0.5 * (share.interval.upper - share.interval.lower) / normal_quantile_95;
}

// Shares of 20 000 random points have standard errors of about 0.005.
constexpr Eigen::Index many = 20'000;
constexpr double share_tolerance = 0.02;

TEST(VarianceShares, OfALinearLawAreItsSquaredSlopes) {
    std::mt19937_64 random(1);
    const MatrixXd x1 = uniform(many, random);
    const MatrixXd x2 = uniform(many, random);
    const VarianceShares found = variance_shares({x1, x2}, 3.0 * x1 + 2.0 * x2);
    EXPECT_EQ(found.points, many);
    EXPECT_EQ(found.columns, 5);
    ASSERT_EQ(found.shares.size(), 3U);
    EXPECT_NEAR(found.shares[0].value, 9.0 / 13.0, share_tolerance);
    EXPECT_NEAR(found.shares[1].value, 4.0 / 13.0, share_tolerance);
    EXPECT_NEAR(found.shares[2].value, 0.0, 1e-9) << "rounding";
}

TEST(VarianceShares, ContainParabolasFarFromZero) {
    // Var x² = 4/45 and Var x = 1/3 on (−1, 1).
    std::mt19937_64 random(2);
    const MatrixXd x1 = uniform(many, random);
    const MatrixXd x2 = uniform(many, random);
    const MatrixXd y = 1e3 + (x1.cwiseAbs2() + 0.5 * x2).array();
    const VarianceShares found = variance_shares({(1e5 + x1.array()).matrix(), x2}, y);
    const double all = 4.0 / 45.0 + 1.0 / 12.0;
    EXPECT_NEAR(found.shares[0].value, 4.0 / 45.0 / all, share_tolerance);
    EXPECT_NEAR(found.shares[1].value, 1.0 / 12.0 / all, share_tolerance);
    EXPECT_NEAR(found.shares[2].value, 0.0, 1e-9);
}

TEST(VarianceShares, LeaveScatterAndInteractionsToTheRest) {
    std::mt19937_64 random(3);
    const MatrixXd x1 = uniform(many, random);
    const MatrixXd x2 = uniform(many, random);
    const MatrixXd idle = uniform(many, random);
    // The variances are 1/3, 1/9 and 1/4.
    const MatrixXd y = x1 + x1.cwiseProduct(x2) + 0.5 * normal(many, random);
    const VarianceShares found = variance_shares({x1, x2, idle}, y);
    EXPECT_NEAR(found.shares[0].value, 12.0 / 25.0, share_tolerance);
    EXPECT_NEAR(found.shares[1].value, 0.0, 1e-3);
    EXPECT_NEAR(found.shares[2].value, 0.0, 1e-3);
    EXPECT_EQ(found.shares[2].interval.lower, 0.0);
    EXPECT_NEAR(found.shares[3].value, 13.0 / 25.0, share_tolerance);
}

TEST(VarianceShares, OfAGroupContainWhatItsInputsExplainTogether) {
    // y = a + b + c with corr(a, b) = 0.8, all standard normal: Var = 2 + 2·0.8 + 1.
    std::mt19937_64 random(4);
    MatrixXd pair(many, 2);
    pair.col(0) = normal(many, random);
    pair.col(1) = 0.8 * pair.col(0) + 0.6 * normal(many, random);
    const MatrixXd c = normal(many, random);
    const VarianceShares found = variance_shares({pair, c}, pair.rowwise().sum() + c);
    EXPECT_NEAR(found.shares[0].value, 3.6 / 4.6, share_tolerance);
    EXPECT_NEAR(found.shares[1].value, 1.0 / 4.6, share_tolerance);
    // A copy adds nothing.
    MatrixXd copies(many, 2);
    copies << c, 3.0 * c;
    const VarianceShares same = variance_shares({pair, copies}, pair.rowwise().sum() + c);
    EXPECT_EQ(same.columns, found.columns);
    EXPECT_NEAR(same.shares[1].value, found.shares[1].value, 1e-9);
}

TEST(VarianceShares, OfLevelsInAFactorialAddUpToOne) {
    // Two levels determine no parabola; a constant determines nothing.
    MatrixXd two(60, 1);
    MatrixXd five(60, 1);
    for (Eigen::Index k = 0; k < 60; ++k) {
        two(k, 0) = k % 2 == 0 ? 10.0 : 12.0;
        five(k, 0) = static_cast<double>(k / 2 % 5);
    }
    const MatrixXd y = two + five.cwiseAbs2() + two.cwiseProduct(five);
    const VarianceShares found = variance_shares({two, five, MatrixXd::Constant(60, 1, 7.0)}, y);
    EXPECT_EQ(found.columns, 4);
    EXPECT_EQ(found.shares[2].value, 0.0);
    double sum = 0.0;
    for (const Share& share : found.shares)
        sum += share.value;
    EXPECT_NEAR(sum, 1.0, 1e-9);
}

TEST(VarianceShares, HaveTheStandardErrorsOfRepeatedSamples) {
    std::mt19937_64 random(5);
    constexpr int samples = 200;
    MatrixXd values(samples, 3);
    MatrixXd errors(samples, 3);
    for (Eigen::Index k = 0; k < samples; ++k) {
        const MatrixXd x1 = uniform(300, random);
        const MatrixXd x2 = uniform(300, random);
        const VarianceShares found =
            variance_shares({x1, x2}, 2.0 * x1 + x2 + 0.5 * normal(300, random));
        for (Eigen::Index g = 0; g < 3; ++g) {
            values(k, g) = found.shares[static_cast<std::size_t>(g)].value;
            errors(k, g) = standard_error(found.shares[static_cast<std::size_t>(g)]);
        }
    }
    for (Eigen::Index g = 0; g < 3; ++g) {
        const double scatter = std::sqrt(
            (values.col(g).array() - values.col(g).mean()).square().sum() / (samples - 1.0));
        EXPECT_GT(errors.col(g).mean(), scatter / 1.5);
        EXPECT_LT(errors.col(g).mean(), scatter * 1.5);
    }
}

TEST(VarianceShares, NeedPointsAndInputsThatVary) {
    std::mt19937_64 random(6);
    const MatrixXd x = uniform(6, random);
    EXPECT_NO_THROW((void)variance_shares({x}, x));
    EXPECT_THROW((void)variance_shares({x.topRows(5)}, x.topRows(5)), core::NumericalError);
    EXPECT_THROW((void)variance_shares({MatrixXd::Ones(6, 1)}, x), core::NumericalError);
    EXPECT_THROW((void)variance_shares({MatrixXd(0, 1)}, MatrixXd(0, 1)), core::NumericalError);
    EXPECT_TRUE(std::isnan(variance_shares({x}, MatrixXd::Ones(6, 1)).shares[0].value));
}

} // namespace
} // namespace culm::reduce
