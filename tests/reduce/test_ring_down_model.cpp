// SPDX-License-Identifier: BSD-3-Clause
// Eq. 1 with phase and offset, and the derivatives of its sum of squares, as the fit uses them.
#include "reduce/ring_down/ring_down_model.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace culm::reduce {
namespace {

const RingDownParameters at{-0.7, -0.8, 1.3, 0.2, 0.05};
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

constexpr FreeRingDownParameters all{.amplitude = true, .quadrature = true, .offset = true};

/// The problem with its derivatives at a step of one free parameter.
RingDownProblem moved(const RingDownSamples& history, const FreeRingDownParameters& free,
                      Eigen::Index parameter, double by) {
    RingDownProblem problem(history, free);
    problem.evaluate(problem.moved(at, by * Eigen::VectorXd::Unit(free.count(), parameter)));
    problem.evaluate_jacobian();
    return problem;
}

Eigen::VectorXd gradient(const RingDownProblem& problem) {
    return problem.jacobian().transpose() * problem.residuals();
}

TEST(RingDownModel, ResidualsAreTheTextbookFormulaLessTheValues) {
    const double b0 = -std::hypot(0.7, 0.2);
    const double phase = std::atan(0.2 / -0.7);
    for (const bool has_equal_intervals : {true, false}) {
        const RingDownSamples history = samples(has_equal_intervals);
        RingDownProblem problem(history, all);
        problem.evaluate(at);
        for (std::size_t k = 0; k < history.times.size(); ++k) {
            const double t = history.times[k];
            const double expected =
                0.05 +
                b0 * std::exp(-0.8 * t) * std::cos(2.0 * std::numbers::pi * 1.3 * t + phase) -
                history.values[k];
            EXPECT_NEAR(problem.residuals()[static_cast<Eigen::Index>(k)], expected,
                        4e-15); // rounding of products of unit phasors
        }
    }
}

TEST(RingDownModel, GradientAndHessianAgreeWithCentralDifferences) {
    for (const bool has_equal_intervals : {true, false})
        for (const FreeRingDownParameters& free :
             {all, FreeRingDownParameters{}, FreeRingDownParameters{.amplitude = false},
              FreeRingDownParameters{.offset = true}}) {
            const RingDownSamples history = samples(has_equal_intervals);
            const RingDownProblem here = moved(history, free, 0, 0.0);
            for (Eigen::Index j = 0; j < free.count(); ++j) {
                const RingDownProblem above = moved(history, free, j, step);
                const RingDownProblem below = moved(history, free, j, -step);
                EXPECT_NEAR(gradient(here)[j],
                            (above.sum_of_squares() - below.sum_of_squares()) / (4.0 * step),
                            derivative_tolerance)
                    << j;
                const Eigen::VectorXd change = (gradient(above) - gradient(below)) / (2.0 * step);
                for (Eigen::Index i = 0; i < free.count(); ++i)
                    EXPECT_NEAR(here.hessian()(i, j), change[i], derivative_tolerance)
                        << i << " " << j;
            }
        }
}

TEST(RingDownModel, ASteepStartFindsTheMinimumOfExactValues) {
    RingDownSamples history = samples(true);
    RingDownProblem exact(history, all);
    exact.evaluate(at);
    for (std::size_t k = 0; k < history.values.size(); ++k)
        history.values[k] += exact.residuals()[static_cast<Eigen::Index>(k)];
    RingDownProblem problem(history, all);
    const auto found = minimum_from(problem, {-0.5, -0.5, 1.25, 0.0, 0.0});
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->parameters.amplitude, at.amplitude, 1e-12);
    EXPECT_NEAR(found->parameters.decay_rate, at.decay_rate, 1e-11);
    EXPECT_NEAR(found->parameters.frequency, at.frequency, 1e-12);
    EXPECT_NEAR(found->parameters.quadrature, at.quadrature, 1e-12);
    EXPECT_NEAR(found->parameters.offset, at.offset, 1e-12);
}

} // namespace
} // namespace culm::reduce
