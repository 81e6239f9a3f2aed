// SPDX-License-Identifier: BSD-3-Clause
#include "fit/solve/solution.hpp"

#include <gtest/gtest.h>

namespace {

using namespace culm;

/// Iterations as Ceres tells of them: after a step that failed, `cost` is that of where it would
/// have led.
class Descent {
  public:
    explicit Descent(double wanted) : callback_(wanted, 50) {}

    ceres::CallbackReturnType step(double change) {
        ceres::IterationSummary summary;
        summary.iteration = iteration_++;
        summary.step_is_successful = change > 0.0;
        summary.cost_change = change;
        summary.cost = cost_ - change;
        if (summary.step_is_successful)
            cost_ = summary.cost;
        return callback_(summary);
    }
    [[nodiscard]] bool is_given_up() const { return callback_.is_so(); }

  private:
    fit::OutOfReach callback_;
    int iteration_ = 0;
    double cost_ = 1000.0;
};

TEST(OutOfReach, IsWhatSlowsDownFarAbove) {
    Descent descent(100.0);
    for (const double change : {1e-9, 8.0, 4.0, 2.0, 1.0})
        EXPECT_EQ(descent.step(change), ceres::SOLVER_CONTINUE);
    EXPECT_EQ(descent.step(0.5), ceres::SOLVER_TERMINATE_SUCCESSFULLY);
    EXPECT_TRUE(descent.is_given_up());
}

TEST(OutOfReach, IsNotWhatGainsSpeed) {
    Descent descent(100.0);
    for (const double change : {1e-9, 0.1, 0.3, 0.9, 2.7, 8.1})
        EXPECT_EQ(descent.step(change), ceres::SOLVER_CONTINUE);
    EXPECT_FALSE(descent.is_given_up());
}

TEST(OutOfReach, IsNotWhatHasComeThereAndTriesAStepThatFails) {
    Descent descent(100.0);
    for (const double change : {1e-9, 920.0, 4.0, 2.0, 1.0, 0.5, 0.25, 0.1})
        EXPECT_EQ(descent.step(change), ceres::SOLVER_CONTINUE);
    for (const double change : {-5e4, -2e3, -300.0})
        EXPECT_EQ(descent.step(change), ceres::SOLVER_CONTINUE);
    EXPECT_FALSE(descent.is_given_up());
}

} // namespace
