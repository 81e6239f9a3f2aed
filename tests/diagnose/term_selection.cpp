// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/missing_force/term_selection.hpp"

#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace culm::tests {
namespace {

/// Eight columns of normal numbers in 20 blocks of 50, and noise of size 1.
struct Problem {
    Eigen::MatrixXd columns = Eigen::MatrixXd(1000, 8);
    Eigen::VectorXd noise = Eigen::VectorXd(1000);
    std::vector<int> block;

    Problem() {
        std::mt19937 engine(7);
        std::normal_distribution<double> normal;
        for (Eigen::Index i = 0; i < columns.rows(); ++i) {
            for (Eigen::Index k = 0; k < columns.cols(); ++k)
                columns(i, k) = normal(engine);
            noise(i) = normal(engine);
            block.push_back(static_cast<int>(i / 50));
        }
    }
};

TEST(TermSelection, FindsTheColumnsThatAreThere) {
    const Problem problem;
    const Eigen::VectorXd residual =
        2.0 * problem.columns.col(5) - 0.7 * problem.columns.col(2) + problem.noise;
    const diagnose::SelectedTerms terms =
        diagnose::select_terms(problem.columns, residual, problem.block, 3);
    ASSERT_EQ(terms.columns, (std::vector<std::size_t>{5, 2}));
    // The standard error of a coefficient is 1/√1000 = 0.03; four of them.
    EXPECT_NEAR(terms.coefficients(0), 2.0, 0.13);
    EXPECT_NEAR(terms.coefficients(1), -0.7, 0.13);
    EXPECT_GE(terms.stability.back(), 0.8);
    // Noise is 1 of 1 + 2² + 0.7²; the scatter of that ratio over 1000 readings is some 5 %.
    EXPECT_NEAR(terms.left, 1.0 / 5.49, 0.02);
}

TEST(TermSelection, FindsNothingInNoise) {
    const Problem problem;
    const diagnose::SelectedTerms terms =
        diagnose::select_terms(problem.columns, problem.noise, problem.block, 3);
    EXPECT_TRUE(terms.columns.empty());
    EXPECT_DOUBLE_EQ(terms.left, 1.0);
}

TEST(TermSelection, RejectsAColumnThatOnlySomeBlocksSupport) {
    Problem problem;
    // The first column appears in one block of twenty only: half of the resamples miss it.
    Eigen::VectorXd residual = problem.noise;
    residual.head(50) += 3.0 * problem.columns.col(0).head(50);
    problem.columns.col(0).tail(950) *= 1e-3;
    const diagnose::SelectedTerms terms =
        diagnose::select_terms(problem.columns, residual, problem.block, 3);
    EXPECT_TRUE(std::ranges::find(terms.columns, 0u) == terms.columns.end());
}

} // namespace
} // namespace culm::tests
