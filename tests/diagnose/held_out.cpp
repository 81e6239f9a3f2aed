// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/held_out.hpp"

#include <gtest/gtest.h>

namespace culm::tests {
namespace {

diagnose::HeldOutPart part(std::vector<double> blocks) {
    diagnose::HeldOutPart made;
    made.blocks = std::move(blocks);
    return made;
}

TEST(PredictsBetter, IfTheBlocksFallByMoreThanTheirScatter) {
    EXPECT_TRUE(diagnose::predicts_better(part({1.0, 1.1, 0.9, 1.0, 1.05}),
                                          part({1.5, 1.8, 1.3, 1.6, 1.5})));
}

TEST(PredictsBetter, NotIfOneBlockDoesItAll) {
    EXPECT_FALSE(diagnose::predicts_better(part({1.0, 1.1, 0.9, 1.0, 1.0}),
                                           part({3.0, 1.0, 0.9, 1.0, 1.0})));
}

TEST(PredictsBetter, WithFewBlocksOnlyIfTheMeanFallsClearly) {
    EXPECT_TRUE(diagnose::predicts_better(part({1.0, 1.0}), part({1.2, 1.2})));
    EXPECT_FALSE(diagnose::predicts_better(part({1.0, 1.0}), part({1.05, 1.05})));
}

TEST(PredictsBetter, NeverIfAFitFailed) {
    diagnose::HeldOutPart failed = part({0.1, 0.1, 0.1, 0.1});
    failed.failure = "not converged";
    EXPECT_FALSE(diagnose::predicts_better(failed, part({1.0, 1.0, 1.0, 1.0})));
}

} // namespace
} // namespace culm::tests
