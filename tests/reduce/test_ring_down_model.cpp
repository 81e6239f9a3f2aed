// SPDX-License-Identifier: BSD-3-Clause
// Eq. 1 and the derivatives of its sum of squares, as the fit uses them.
#include "reduce/ring_down/ring_down_model.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace culm::reduce {
namespace {

const RingDownParameters at{-0.7, -0.8, 1.3};
// Central differences: truncation about step² = 1e-12 times third derivatives of a sum over 200
// samples (below 1e5), rounding about 1e-14/1e-6.
constexpr double step = 1e-6;
constexpr double derivative_tolerance = 2e-7;

/// Residuals that are not small, so that the Hessian is far from JᵀJ. Equal intervals take the
/// blockwise path of RingDownBasis, the others the plain one.
RingDownSamples samples(bool has_equal_intervals) {
    RingDownSamples made;
    for (int k = 0; k < 200; ++k) {
        made.times.push_back(0.01 * k + (has_equal_intervals ? 0.0 : 1e-3 * std::sin(5.0 * k)));
        made.values.push_back(0.3 * std::cos(7.0 * k));
    }
    return made;
}

RingDownParameters shifted(int parameter, double by) {
    RingDownParameters p = at;
    (parameter == 0 ? p.amplitude : parameter == 1 ? p.decay_rate : p.frequency) += by;
    return p;
}

TEST(RingDownModel, ResidualsAreTheTextbookFormulaLessTheValues) {
    for (const bool has_equal_intervals : {true, false}) {
        const RingDownSamples history = samples(has_equal_intervals);
        RingDownLinearisation model(history);
        model.evaluate_residuals(at);
        for (std::size_t k = 0; k < history.times.size(); ++k) {
            const double t = history.times[k];
            const double expected =
                -0.7 * std::exp(-0.8 * t) * std::cos(2.0 * std::numbers::pi * 1.3 * t) -
                history.values[k];
            EXPECT_NEAR(model.residuals()[static_cast<Eigen::Index>(k)], expected,
                        4e-15); // rounding of products of unit phasors
        }
    }
}

TEST(RingDownModel, GradientAgreesWithCentralDifferences) {
    for (const bool has_equal_intervals : {true, false}) {
        RingDownLinearisation model(samples(has_equal_intervals));
        const Eigen::Vector3d gradient = curvature(model, at, true).gradient;
        for (int j = 0; j < 3; ++j) {
            const double difference =
                (curvature(model, shifted(j, step), true).residual_sum_of_squares -
                 curvature(model, shifted(j, -step), true).residual_sum_of_squares) /
                (4.0 * step);
            EXPECT_NEAR(gradient[j], difference, derivative_tolerance) << j;
        }
    }
}

TEST(RingDownModel, HessianAgreesWithCentralDifferencesOfTheGradient) {
    for (const bool has_equal_intervals : {true, false}) {
        RingDownLinearisation model(samples(has_equal_intervals));
        const Eigen::Matrix3d hessian = curvature(model, at, true).newton;
        for (int j = 0; j < 3; ++j) {
            const Eigen::Vector3d difference =
                (curvature(model, shifted(j, step), true).gradient -
                 curvature(model, shifted(j, -step), true).gradient) /
                (2.0 * step);
            for (int i = 0; i < 3; ++i)
                EXPECT_NEAR(hessian(i, j), difference[i], derivative_tolerance) << i << " " << j;
        }
    }
}

TEST(RingDownModel, AFixedAmplitudeTakesNoStep) {
    RingDownLinearisation model(samples(true));
    const RingDownCurvature fixed = curvature(model, at, false);
    EXPECT_EQ(fixed.gradient[0], 0.0);
    for (const Eigen::Matrix3d& matrix : {fixed.newton, fixed.gauss_newton}) {
        EXPECT_EQ(matrix(0, 0), 1.0);
        for (int j : {1, 2})
            EXPECT_EQ(matrix(0, j), 0.0);
    }
}

} // namespace
} // namespace culm::reduce
