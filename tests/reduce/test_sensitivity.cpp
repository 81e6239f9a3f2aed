// SPDX-License-Identifier: BSD-3-Clause
// Sobol indices against closed forms: Ishigami's function, linear models, levels, dependent inputs.
#include "core/error.hpp"
#include "reduce/sensitivity.hpp"

#include <cmath>
#include <numbers>
#include <random>

#include <fmt/core.h>
#include <gtest/gtest.h>

namespace culm::reduce {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Midpoints of equal parts of (low, high).
InputGroup uniform_input(const std::string& name, double low, double high, Eigen::Index points,
                         std::mt19937_64& random) {
    constexpr Eigen::Index nodes = 4000;
    InputGroup group{name, MatrixXd(points, 1), MatrixXd(nodes, 1),
                     VectorXd::Constant(nodes, 1.0 / nodes)};
    std::uniform_real_distribution<double> draw(low, high);
    for (double& value : group.values.reshaped())
        value = draw(random);
    for (Eigen::Index k = 0; k < nodes; ++k)
        group.nodes(k, 0) = low + (high - low) * (static_cast<double>(k) + 0.5) / nodes;
    return group;
}

std::vector<InputGroup> uniform_inputs(int count, double low, double high, Eigen::Index points,
                                       std::mt19937_64& random) {
    std::vector<InputGroup> groups;
    for (int k = 0; k < count; ++k)
        groups.push_back(uniform_input(fmt::format("x{}", k + 1), low, high, points, random));
    return groups;
}

TEST(GroupPolynomials, AreLegendrePolynomialsOnAnInterval) {
    std::mt19937_64 random(1);
    const InputGroup group = uniform_input("x", -1.0, 1.0, 1, random);
    const GroupPolynomials polynomials(group.nodes, group.weights, 3);
    ASSERT_EQ(polynomials.degrees(), (std::vector<int>{1, 2, 3}));
    const MatrixXd values = polynomials.at(MatrixXd::Constant(1, 1, 0.5));
    // The midpoint rule of 4000 nodes has an error of 1/4000², which the polynomials amplify.
    EXPECT_NEAR(std::abs(values(0, 0)), std::sqrt(3.0) * 0.5, 1e-5);
    EXPECT_NEAR(std::abs(values(0, 1)), std::sqrt(5.0) * 0.125, 1e-5);
    EXPECT_NEAR(std::abs(values(0, 2)), std::sqrt(7.0) * 0.4375, 1e-5);
}

TEST(GroupPolynomials, ThreeLevelsHaveTwoFunctions) {
    const GroupPolynomials polynomials(VectorXd{{1.0, 2.0, 5.0}}, VectorXd::Constant(3, 1.0 / 3.0),
                                       8);
    EXPECT_EQ(polynomials.degrees(), (std::vector<int>{1, 2}));
}

TEST(GroupPolynomials, StayOrthonormalAtHighDegreesOfAWideDistribution) {
    std::mt19937_64 random(1);
    InputGroup group = uniform_input("x", -1.0, 1.0, 1, random);
    group.nodes = group.nodes.array().exp().matrix() * 1e9; // far from zero, skewed
    const GroupPolynomials polynomials(group.nodes, group.weights, 12);
    const MatrixXd values = polynomials.at(group.nodes);
    const MatrixXd gram = values.transpose() * group.weights.asDiagonal() * values;
    // Monomials of degree 12 lose about nine of sixteen digits.
    EXPECT_LT((gram - MatrixXd::Identity(gram.rows(), gram.cols())).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(Sensitivity, MatchesThePublishedValuesForIshigamisFunction) {
    // y = sin x1 + a sin² x2 + b x3⁴ sin x1 on (−π, π)³ (Ishigami & Homma 1990), a = 7, b = 0.1.
    constexpr double a = 7.0;
    constexpr double b = 0.1;
    constexpr double pi = std::numbers::pi;
    std::mt19937_64 random(3);
    const auto groups = uniform_inputs(3, -pi, pi, 2000, random);
    MatrixXd y(2000, 1);
    for (Eigen::Index k = 0; k < y.rows(); ++k) {
        const double x1 = groups[0].values(k, 0);
        const double x2 = groups[1].values(k, 0);
        const double x3 = groups[2].values(k, 0);
        y(k, 0) = std::sin(x1) + a * std::pow(std::sin(x2), 2) + b * std::pow(x3, 4) * std::sin(x1);
    }
    const double v1 = 0.5 * std::pow(1.0 + b * std::pow(pi, 4) / 5.0, 2);
    const double v2 = a * a / 8.0;
    const double v13 = b * b * std::pow(pi, 8) * 8.0 / 225.0;
    const double v = v1 + v2 + v13;
    const Sensitivity found = analyse_sensitivity(groups, y).front();
    EXPECT_GE(found.degree, 9);
    EXPECT_GT(found.predicted_share, 0.999);
    // The neglected terms are below 0.1 % of the variance.
    EXPECT_NEAR(found.mean, a / 2.0, 0.01);
    EXPECT_NEAR(found.standard_deviation, std::sqrt(v), 0.01);
    EXPECT_NEAR(found.groups[0].first_order.value, v1 / v, 2e-3);
    EXPECT_NEAR(found.groups[1].first_order.value, v2 / v, 2e-3);
    EXPECT_NEAR(found.groups[2].first_order.value, 0.0, 2e-3);
    EXPECT_NEAR(found.groups[0].total.value, (v1 + v13) / v, 2e-3);
    EXPECT_NEAR(found.groups[1].total.value, v2 / v, 2e-3);
    EXPECT_NEAR(found.groups[2].total.value, v13 / v, 2e-3);
    EXPECT_NEAR(found.interactions, v13 / v, 2e-3);
}

TEST(Sensitivity, FollowsTheSquaredSlopesOfALinearModel) {
    std::mt19937_64 random(5);
    const auto groups = uniform_inputs(3, 0.0, 1.0, 40, random);
    MatrixXd y(40, 2);
    y.col(0) = 5.0 + (3.0 * groups[0].values + 2.0 * groups[1].values + groups[2].values).array();
    y.col(1).setConstant(4.0);
    const auto found = analyse_sensitivity(groups, y);
    EXPECT_EQ(found[0].degree, 1);
    // Rounding only: the nodes' variance has the same relative error, 1/4000², for all three.
    for (const int k : {0, 1, 2}) {
        const double share = std::pow(3 - k, 2) / 14.0;
        EXPECT_NEAR(found[0].groups[std::size_t(k)].first_order.value, share, 1e-9);
        EXPECT_NEAR(found[0].groups[std::size_t(k)].total.value, share, 1e-9);
    }
    EXPECT_NEAR(found[0].standard_deviation, std::sqrt(14.0 / 12.0), 1e-6);
    EXPECT_EQ(found[1].degree, 0) << "nothing varies";
    EXPECT_EQ(found[1].mean, 4.0);
}

TEST(Sensitivity, IntervalsCoverTheTruthUnderNoise) {
    std::mt19937_64 random(11);
    std::normal_distribution<double> noise(0.0, 0.5);
    constexpr int samples = 400;
    int first = 0;
    int zero = 0;
    for (int k = 0; k < samples; ++k) {
        const auto groups = uniform_inputs(3, 0.0, 1.0, 120, random);
        MatrixXd y = 3.0 * groups[0].values + 2.0 * groups[1].values;
        for (double& value : y.reshaped())
            value += noise(random);
        const Sensitivity found = analyse_sensitivity(groups, y).front();
        const Bounds& of_first = found.groups[0].first_order.interval;
        first += of_first.lower <= 9.0 / 13.0 && 9.0 / 13.0 <= of_first.upper;
        zero += found.groups[2].total.interval.lower == 0.0;
    }
    // 95 % of 400 with a standard deviation of 1.1 %; four of them. An index of zero lies at the
    // end of its range, where the interval of second order covers more.
    EXPECT_NEAR(first, 380, 18);
    EXPECT_GE(zero, 370);
}

TEST(Sensitivity, DependentInputsShareAnIndexThatHasNoDoubleCount) {
    // y = a + b + c with corr(a, b) = 0.8, all standard normal: Var = 2 + 2·0.8 + 1.
    std::mt19937_64 random(17);
    std::normal_distribution<double> normal;
    const auto pairs = [&](Eigen::Index count) {
        MatrixXd rows(count, 2);
        for (Eigen::Index k = 0; k < count; ++k) {
            rows(k, 0) = normal(random);
            rows(k, 1) = 0.8 * rows(k, 0) + 0.6 * normal(random);
        }
        return rows;
    };
    constexpr Eigen::Index points = 200;
    const MatrixXd nodes = pairs(20'000);
    InputGroup c{"c", MatrixXd(points, 1), nodes.col(0), VectorXd::Constant(20'000, 1.0 / 20'000)};
    for (double& value : c.values.reshaped())
        value = normal(random);
    const std::vector<InputGroup> groups{{"a, b", pairs(points), nodes, c.weights}, c};
    const MatrixXd y = groups[0].values.rowwise().sum() + c.values;
    const Sensitivity found = analyse_sensitivity(groups, y).front();
    // 20 000 random nodes determine variances to 1 %.
    EXPECT_NEAR(found.groups[0].first_order.value, 3.6 / 4.6, 0.01);
    EXPECT_NEAR(found.groups[1].total.value, 1.0 / 4.6, 0.01);
}

TEST(Sensitivity, TooFewPointsAreRefused) {
    std::mt19937_64 random(5);
    const auto groups = uniform_inputs(5, 0.0, 1.0, 8, random);
    EXPECT_THROW((void)analyse_sensitivity(groups, MatrixXd::Ones(8, 1)), core::NumericalError);
}

} // namespace
} // namespace culm::reduce
