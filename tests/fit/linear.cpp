// SPDX-License-Identifier: BSD-3-Clause
#include "fit/linear/scaled_solve.hpp"
#include "fit/linear/weighted_system.hpp"

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <Eigen/Dense>
#include <gtest/gtest.h>

namespace culm::tests {
namespace {

// Near the tip the reading of one lane may be missing: that derivative alone is dropped.
TEST(WeightedSystem, KeepsTheDerivativesBesideAMissingOne) {
    fit::StemModel model;
    fit::ObservedRecording recording;
    recording.stem.id = "a";
    recording.heights = {0.1};
    recording.times = {0.0, 0.1};
    recording.deflections = {1e-4, 2e-4};
    for (const char* const name : {"one", "two"}) {
        fit::FreeParameter& parameter = model.parameters.emplace_back();
        parameter.access.id = {{}, name, {}};
    }
    fit::ChainPrediction prediction;
    prediction.frames = 2;
    prediction.rows = 1;
    prediction.parameters = 2;
    prediction.readings = {0.0, 0.0};
    prediction.jacobian = {std::nan(""), 3e-4, 5e-4, 7e-4};
    const std::vector<double> noise{1e-4};
    const std::vector<fit::ErrorTerm> terms{{fit::ErrorKind::Place, "place", {2e-4, 0.0}}};
    const fit::SystemPart part{model, recording, prediction, noise, terms};
    const fit::WeightedSystem system =
        fit::weighted_system(fit::joint_layout({&model, 1}, {&recording, 1}), {&part, 1});
    const Eigen::MatrixXd wanted{{0.0, 3.0, 2.0}, {5.0, 7.0, 0.0}, {0.0, 0.0, 1.0}};
    EXPECT_TRUE(system.jacobian.isApprox(wanted)) << system.jacobian;
    EXPECT_EQ(system.constraints, 1);
    EXPECT_TRUE(system.residual.isApprox(Eigen::Vector3d(1.0, 2.0, 0.0)));
}

/// A random matrix J with columns of very different units, and JᵀJ.
Eigen::MatrixXd information(unsigned seed, Eigen::Index count) {
    std::mt19937 dice(seed);
    std::normal_distribution<double> normal;
    Eigen::MatrixXd jacobian(3 * count, count);
    for (double& entry : jacobian.reshaped())
        entry = normal(dice);
    for (Eigen::Index k = 0; k < count; ++k)
        jacobian.col(k) *= std::pow(10.0, 4.0 * static_cast<double>(k) - 6.0);
    return jacobian.transpose() * jacobian;
}

TEST(ScaledSpectrum, SolvesAcrossUnits) {
    const Eigen::MatrixXd matrix = information(1, 4);
    const Eigen::VectorXd wanted{{1e5, -2.0, 3e-4, 5e-9}};
    const Eigen::VectorXd found = fit::ScaledSpectrum(matrix).solve(matrix * wanted);
    for (Eigen::Index k = 0; k < 4; ++k)
        EXPECT_NEAR(found(k) / wanted(k), 1.0, 1e-8);
    EXPECT_NEAR(fit::ScaledSpectrum(matrix).log_determinant(), std::log(matrix.determinant()),
                1e-6);
}

TEST(ScaledSpectrum, TellsWhichUnknownsAreUndetermined) {
    Eigen::MatrixXd jacobian(3, 3); // the last two columns are parallel
    jacobian << 1.0, 1e6, 2e6, 0.0, 3e6, 6e6, 2.0, 0.0, 0.0;
    const fit::ScaledSpectrum spectrum(jacobian.transpose() * jacobian);
    EXPECT_FALSE(spectrum.is_unknown(0));
    EXPECT_TRUE(spectrum.is_unknown(1));
    EXPECT_TRUE(std::isinf(spectrum.covariance()(2, 2)));
}

// Compares with the best of all sets of active bounds.
TEST(BoundedMinimum, IsTheBestOfAllSetsOfBounds) {
    std::mt19937 dice(5);
    std::normal_distribution<double> normal;
    constexpr Eigen::Index count = 4;
    for (unsigned seed = 0; seed < 200; ++seed) {
        const Eigen::MatrixXd matrix = information(seed, count);
        Eigen::VectorXd right(count);
        Eigen::VectorXd lower(count);
        Eigen::VectorXd upper(count);
        for (Eigen::Index k = 0; k < count; ++k) {
            const double unit = 1.0 / std::sqrt(matrix(k, k));
            right(k) = 3.0 * normal(dice) / unit;
            lower(k) = -std::abs(normal(dice)) * unit;
            upper(k) = seed % 3 == 0 ? std::numeric_limits<double>::infinity()
                                     : std::abs(normal(dice)) * unit;
        }
        const auto value = [&](const Eigen::VectorXd& at) {
            return 0.5 * at.dot(matrix * at) - right.dot(at);
        };
        double least = std::numeric_limits<double>::infinity();
        for (int set = 0; set < 81; ++set) { // each unknown free, or at one of its bounds
            Eigen::VectorXd at = Eigen::VectorXd::Zero(count);
            std::vector<Eigen::Index> free;
            for (Eigen::Index k = 0, rest = set; k < count; ++k, rest /= 3)
                if (rest % 3 == 0)
                    free.push_back(k);
                else
                    at(k) = (rest % 3 == 1 ? lower : upper)(k);
            if (!at.allFinite())
                continue;
            if (!free.empty())
                at(free) = fit::ScaledSpectrum(matrix(free, free))
                               .solve((right - matrix * at)(free))
                               .col(0);
            const bool is_allowed =
                ((at - lower).array() >= 0.0).all() && ((upper - at).array() >= 0.0).all();
            if (is_allowed)
                least = std::min(least, value(at));
        }
        const Eigen::VectorXd found = fit::bounded_minimum(matrix, right, lower, upper);
        EXPECT_TRUE(((found - lower).array() >= 0.0).all());
        EXPECT_TRUE(((upper - found).array() >= 0.0).all());
        EXPECT_NEAR(value(found), least, 1e-6 * (1.0 + std::abs(least))) << seed;
    }
}

} // namespace
} // namespace culm::tests
