// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/evidence/effect_view.hpp"
#include "diagnose/evidence/log_evidence.hpp"

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace culm::tests {
namespace {

/// The evidence of candidates beside a model with one own parameter and this residual.
diagnose::LinearEvidence evidence(const Eigen::VectorXd& own, const Eigen::VectorXd& residual,
                                  std::vector<diagnose::EffectColumns> candidates) {
    diagnose::SharedColumns stem;
    stem.own = {0};
    stem.system.jacobian = own;
    stem.system.residual = residual;
    stem.system.fitted = own.cols();
    const diagnose::EffectView view = view_of(std::move(candidates), stem);
    return {view.columns, view.gram, view.overlap};
}

diagnose::EffectColumns effect(const Eigen::VectorXd& column, bool is_one_sided) {
    diagnose::EffectColumn one;
    one.readings = column;
    one.parameter = 0;
    one.is_one_sided = is_one_sided;
    diagnose::EffectColumns out;
    out.nodes.push_back({{0.0}, 1.0, 1.0, {one}});
    return out;
}

// Compares with the integral itself: log of ∫ exp(-|r - a s|²/2) N(a; 0, 1) da over exp(-|r|²/2).
TEST(LinearEvidence, EqualsTheIntegralOverTheSize) {
    const Eigen::VectorXd own{{1.0, 0.0, 0.0}};
    const Eigen::VectorXd residual{{0.3, 2.0, -1.0}};
    const Eigen::VectorXd column{{5.0, 1.5, 0.5}};
    const diagnose::LinearEvidence linear = evidence(own, residual, {effect(column, false)});
    const std::vector<std::size_t> set{0};
    const diagnose::PredictedGain gain = linear.gain(set);
    // Column and residual without the part that the own parameter imitates.
    const Eigen::VectorXd seen{{0.0, 1.5, 0.5}};
    const Eigen::VectorXd left{{0.0, 2.0, -1.0}};
    double sum = 0.0;
    constexpr double step = 1e-3;
    for (int k = -10000; k < 10000; ++k) {
        const double a = k * step;
        sum += step *
               std::exp(-0.5 * (left - a * seen).squaredNorm() + 0.5 * left.squaredNorm() -
                        0.5 * a * a) /
               std::sqrt(2.0 * std::numbers::pi);
    }
    EXPECT_NEAR(gain.log_evidence, std::log(sum) + diagnose::log_prior_odds(), 1e-6);
}

TEST(LinearEvidence, RejectsASizeWithTheForbiddenSign) {
    const Eigen::VectorXd own{{1.0, 0.0, 0.0}};
    const Eigen::VectorXd residual{{0.0, 2.0, 0.0}};
    const std::vector<std::size_t> set{0};
    const Eigen::VectorXd column{{0.0, -3.0, 0.0}};
    const diagnose::LinearEvidence either = evidence(own, residual, {effect(column, false)});
    EXPECT_TRUE(std::isfinite(either.gain(set).log_evidence));
    const diagnose::LinearEvidence one_sided = evidence(own, residual, {effect(column, true)});
    EXPECT_EQ(one_sided.gain(set).log_evidence, -HUGE_VAL);
}

TEST(LinearEvidence, IsLowerForTwoEqualEffectsThanForOne) {
    const Eigen::VectorXd own{{1.0, 0.0, 0.0}};
    const Eigen::VectorXd residual{{0.0, 4.0, 0.0}};
    const Eigen::VectorXd column{{0.0, 3.0, 0.0}};
    const diagnose::LinearEvidence linear =
        evidence(own, residual, {effect(column, false), effect(column, false)});
    const std::vector<std::size_t> one{0};
    const std::vector<std::size_t> both{0, 1};
    EXPECT_LT(linear.gain(both).log_evidence, linear.gain(one).log_evidence - 2.0);
}

// The evidence does not change by a position or a size that the readings do not determine.
TEST(LogEvidence, EqualsThatOfTheSmallerModelForUndeterminedParameters) {
    diagnose::ParameterPrior size;
    size.deviation = 0.3;
    diagnose::ParameterPrior place;
    place.is_place = true;
    place.range = 7.0;
    diagnose::ModelEvidence smaller;
    smaller.misfits = {1000.0};
    diagnose::ModelEvidence larger;
    larger.misfits = smaller.misfits;
    larger.information = Eigen::MatrixXd::Zero(2, 2);
    larger.log_prior = size.log_density(0.0) + place.log_density(2.0);
    larger.prior_precision = {size.precision(), place.precision()};
    const diagnose::NoiseScale noise{{1.0}, {true}, {1000}};
    EXPECT_NEAR(log_evidence(larger, noise), log_evidence(smaller, noise), 1e-9);
}

TEST(LogEvidence, FollowsTheMeanSquareForUnknownNoise) {
    diagnose::ModelEvidence one;
    one.misfits = {1000.0 * 4e-8};
    diagnose::ModelEvidence other;
    other.misfits = {1000.0 * 1e-8};
    const diagnose::NoiseScale noise{{1e-8}, {false}, {1000}};
    EXPECT_NEAR(log_evidence(other, noise) - log_evidence(one, noise), 500.0 * std::log(4.0), 1e-9);
}

} // namespace
} // namespace culm::tests
