// SPDX-License-Identifier: BSD-3-Clause
// Eq. 1 and its derivatives.
#include "reduce/ring_down_model.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace culm::reduce {
namespace {

const RingDownParameters at{-0.7, -0.8, 1.3};
constexpr double time = 0.37;
// Central differences: truncation about step² = 1e-12 times third derivatives (below 1e3), rounding
// about 1e-16/1e-6.
constexpr double step = 1e-6;
constexpr double tolerance = 1e-8;

RingDownParameters shifted(int parameter, double by) {
    RingDownParameters p = at;
    (parameter == 0 ? p.amplitude : parameter == 1 ? p.decay_rate : p.frequency) += by;
    return p;
}

TEST(RingDownModel, ValueIsTheTextbookFormula) {
    const double expected =
        -0.7 * std::exp(-0.8 * time) * std::cos(2.0 * std::numbers::pi * 1.3 * time);
    EXPECT_NEAR(evaluate_ring_down(at, time).value, expected, 1e-15); // rounding
}

TEST(RingDownModel, GradientAgreesWithCentralDifferences) {
    for (int j = 0; j < 3; ++j) {
        const double difference = (evaluate_ring_down(shifted(j, step), time).value -
                                   evaluate_ring_down(shifted(j, -step), time).value) /
                                  (2.0 * step);
        EXPECT_NEAR(evaluate_ring_down(at, time).gradient[j], difference, tolerance) << j;
    }
}

TEST(RingDownModel, HessianAgreesWithCentralDifferencesOfTheGradient) {
    const Eigen::Matrix3d hessian =
        ring_down_hessian(at, time, evaluate_ring_down(at, time).gradient);
    for (int j = 0; j < 3; ++j) {
        const Eigen::Vector3d difference = (evaluate_ring_down(shifted(j, step), time).gradient -
                                            evaluate_ring_down(shifted(j, -step), time).gradient) /
                                           (2.0 * step);
        for (int i = 0; i < 3; ++i)
            EXPECT_NEAR(hessian(i, j), difference[i], tolerance) << i << " " << j;
    }
}

} // namespace
} // namespace culm::reduce
