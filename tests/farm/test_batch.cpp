// SPDX-License-Identifier: BSD-3-Clause
// The plan's order and the fingerprint of a list of batches.
#include "farm/batch.hpp"

#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>

namespace culm::farm {
namespace {

std::string text_of_error(double cost) {
    const std::vector<Batch> batches = {{{1}, 1.0}, {{2}, cost}};
    try {
        (void)plan_order(batches);
    } catch (const FarmError& error) {
        return error.what();
    }
    return "no error";
}

TEST(PlanOrder, PutsTheLongestBatchFirst) {
    const std::vector<Batch> batches = {{{0}, 1.0}, {{1}, 5.0}, {{2}, 3.0}};
    EXPECT_EQ(plan_order(batches), (std::vector<std::size_t>{1, 2, 0}));
}

TEST(PlanOrder, BreaksTiesByTheFirstPointThenByIndex) {
    const std::vector<Batch> batches = {
        {{9}, 2.0}, {{4, 1}, 2.0}, {{7}, 2.0}, {{4}, 2.0}, {{}, 2.0}};
    EXPECT_EQ(plan_order(batches), (std::vector<std::size_t>{4, 1, 3, 2, 0}));
}

TEST(PlanOrder, IsEmptyWithoutBatches) {
    EXPECT_TRUE(plan_order({}).empty());
}

TEST(PlanOrder, RefusesCostsThatCannotBeOrdered) {
    EXPECT_EQ(text_of_error(-1.0), "batch 1: cost = -1: must be finite and not negative");
    EXPECT_EQ(text_of_error(std::nan("")), "batch 1: cost = nan: must be finite and not negative");
    EXPECT_EQ(text_of_error(std::numeric_limits<double>::infinity()),
              "batch 1: cost = inf: must be finite and not negative");
}

TEST(Digest, DiffersWithAPointACostOrABorderBetweenBatches) {
    const std::vector<Batch> base = {{{0, 1}, 1.0}, {{2}, 1.0}};
    EXPECT_EQ(digest(base), digest(std::vector<Batch>(base)));
    EXPECT_NE(digest(base), digest(std::vector<Batch>{{{0, 1}, 1.0}, {{3}, 1.0}}));
    EXPECT_NE(digest(base), digest(std::vector<Batch>{{{0, 1}, 1.0}, {{2}, 1.5}}));
    EXPECT_NE(digest(base), digest(std::vector<Batch>{{{0}, 1.0}, {{1, 2}, 1.0}}));
}

TEST(Digest, IsTheOffsetBasisOfFnv1aWithoutBatches) {
    EXPECT_EQ(digest({}), 0xcbf29ce484222325ULL);
}

} // namespace
} // namespace culm::farm
