// SPDX-License-Identifier: BSD-3-Clause
// Quantiles and tail probabilities against closed forms.
#include "reduce/distributions.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

namespace culm::reduce {
namespace {

// Both sides are evaluated in double precision and differ by rounding only.
constexpr double tolerance = 1e-12;

TEST(Distributions, StudentTFactorMatchesTheClosedFormsOfOneAndTwoDegreesOfFreedom) {
    // Cauchy: tan(π (p − 1/2)); two degrees: (2p − 1)/√(2p(1 − p)); p = 0.975.
    EXPECT_NEAR(student_t_factor(1), std::tan(std::numbers::pi * 0.475), 1e-10);
    EXPECT_NEAR(student_t_factor(2), 0.95 / std::sqrt(2.0 * 0.975 * 0.025), 1e-10);
    EXPECT_NEAR(student_t_factor(100000000), 1.959963984540054, 1e-6); // the normal's quantile
}

TEST(Distributions, StudentTPValueMatchesTheClosedForm) {
    EXPECT_NEAR(student_t_p_value(1.0, 1), 0.5, tolerance);
    EXPECT_NEAR(student_t_p_value(-3.0, 2), 1.0 - 3.0 / std::sqrt(11.0), tolerance);
    EXPECT_EQ(student_t_p_value(std::numeric_limits<double>::infinity(), 4), 0.0);
}

TEST(Distributions, FisherFPValueMatchesTheClosedForm) {
    // Two degrees of freedom in the numerator: (1 + 2F/n)^(−n/2).
    EXPECT_NEAR(fisher_f_p_value(3.2, 2, 17), std::pow(1.0 + 6.4 / 17.0, -8.5), tolerance);
    // One in the numerator: the square of Student's t.
    EXPECT_NEAR(fisher_f_p_value(9.0, 1, 12), student_t_p_value(3.0, 12), tolerance);
    EXPECT_EQ(fisher_f_p_value(0.0, 2, 17), 1.0);
    EXPECT_EQ(fisher_f_p_value(std::numeric_limits<double>::infinity(), 2, 17), 0.0);
}

} // namespace
} // namespace culm::reduce
