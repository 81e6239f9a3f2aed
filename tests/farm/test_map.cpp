// SPDX-License-Identifier: BSD-3-Clause
// Every point is computed exactly once on any number of ranks, and failures stay local.
#include "farm_fixture.hpp"

#include <algorithm>
#include <stdexcept>

namespace culm::farm {
namespace {

class FarmMap : public FarmTest {
  protected:
    /// Maps, expects every point once and a matching summary. Collective.
    void expect_complete(const std::vector<Batch>& batches, const FarmOptions& options = {},
                         double milliseconds_per_cost = 0.0) {
        std::vector<std::int64_t> mine;
        const Summary summary = farm_.map(
            batches,
            [&](const Batch& batch, Heartbeat& heartbeat) {
                spin(milliseconds_per_cost * batch.cost, heartbeat);
                mine.insert(mine.end(), batch.points.begin(), batch.points.end());
                return all_completed(batch);
            },
            options);
        std::int64_t points = 0;
        for (const Batch& batch : batches)
            points += static_cast<std::int64_t>(batch.points.size());
        expect_each_once(count_everywhere(mine), points);
        EXPECT_EQ(summary.points_total, points);
        EXPECT_EQ(summary.points_completed, points);
        EXPECT_EQ(summary.ranks, world_.size());
        EXPECT_FALSE(summary.stopped_early);
        EXPECT_TRUE(summary.lost.empty());
        expect_same_everywhere(summary);
    }
};

TEST_F(FarmMap, ComputesEveryPointOnceForManyShapesOfBatches) {
    for (const std::int64_t count : {1, 2, 3, 5, 50, 3000})
        for (const std::int64_t size : {1, 8}) {
            SCOPED_TRACE(count);
            expect_complete(equal_batches(count, size));
        }
}

TEST_F(FarmMap, ComputesEveryPointOnceWhenBatchesGoOneByOne) {
    FarmOptions options;
    options.chunk_seconds = 0.0;
    expect_complete(equal_batches(2000, 1), options);
}

TEST_F(FarmMap, ComputesEveryPointOnceWhenItAlwaysPollsMessages) {
    FarmOptions options;
    options.chunk_seconds = 0.0;
    options.poll_interval = std::chrono::microseconds(0);
    expect_complete(equal_batches(500, 3), options);
}

TEST_F(FarmMap, HandlesMoreRanksThanBatches) {
    expect_complete(equal_batches(world_.size() - 1, 2));
}

TEST_F(FarmMap, HandlesNoBatchesAndBatchesWithoutPoints) {
    expect_complete({});
    expect_complete(std::vector<Batch>(7));
}

TEST_F(FarmMap, ComputesEveryPointOnceWhenCostsAreUneven) {
    std::vector<Batch> batches = equal_batches(40, 2);
    for (std::size_t i = 0; i < batches.size(); ++i)
        batches[i].cost = static_cast<double>((7 * i) % 11);
    expect_complete(batches, {}, 0.5);
}

TEST_F(FarmMap, ComputesEveryPointOnceWhenTheCostsMislead) {
    std::vector<Batch> batches = equal_batches(400, 1);
    for (std::size_t i = 0; i < batches.size(); ++i)
        batches[i].cost = i % 40 == 39 ? 1e-3 : 1.0;
    std::vector<std::int64_t> mine;
    (void)farm_.map(batches, [&](const Batch& batch, Heartbeat& heartbeat) {
        // The batches that claim to be short are the long ones.
        if (batch.cost < 1.0)
            spin(3.0, heartbeat);
        mine.push_back(batch.points.front());
        return all_completed(batch);
    });
    expect_each_once(count_everywhere(mine), 400);
}

TEST_F(FarmMap, CanBeCalledManyTimes) {
    for (int i = 0; i < 200; ++i)
        expect_complete(equal_batches(i % 9, 1));
}

TEST_F(FarmMap, ListsABatchThatThrowsAsLostAndContinues) {
    std::vector<std::int64_t> mine;
    const Summary summary = farm_.map(equal_batches(100, 2), [&](const Batch& batch, Heartbeat&) {
        if (batch.points.front() == 40 || batch.points.front() == 86)
            throw std::runtime_error("no luck with " + std::to_string(batch.points.front()));
        mine.insert(mine.end(), batch.points.begin(), batch.points.end());
        return BatchReport{1, 1, 0.0};
    });
    EXPECT_EQ(count_everywhere(mine).size(), 196U);
    ASSERT_EQ(summary.lost.size(), 2U);
    EXPECT_EQ(summary.lost[0].batch, 20U);
    EXPECT_EQ(summary.lost[0].reason, "no luck with 40");
    EXPECT_EQ(summary.lost[1].batch, 43U);
    EXPECT_EQ(summary.points_lost, 4);
    EXPECT_EQ(summary.points_completed, 98);
    EXPECT_EQ(summary.points_failed, 98);
    EXPECT_FALSE(summary.stopped_early);
    EXPECT_TRUE(summary.failure.empty());
    expect_same_everywhere(summary);
}

TEST_F(FarmMap, SurvivesALongErrorTextFromEveryBatch) {
    // The reports are then far longer than what MPI sends eagerly.
    const Summary summary =
        farm_.map(equal_batches(300, 1), [](const Batch&, Heartbeat&) -> BatchReport {
            throw std::runtime_error(std::string(5000, 'x'));
        });
    EXPECT_EQ(summary.lost.size(), 300U);
    EXPECT_EQ(summary.points_lost, 300);
    expect_same_everywhere(summary);
}

TEST_F(FarmMap, ServesOtherRanksWhileRank0Computes) {
    if (world_.size() == 1)
        GTEST_SKIP() << "nobody to serve";
    // Rank 0 gets the longest batch and ends it only after the others have done all the rest. This
    // is far more than the opening hand, so rank 0 must have answered them in between.
    std::vector<Batch> batches = equal_batches(200, 1);
    batches[0].cost = 1000.0;
    std::int64_t done = 0;
    FarmOptions options;
    options.chunk_seconds = 0.0;
    options.progress_interval = std::chrono::milliseconds(0);
    options.progress = [&](const Progress& progress) { done = progress.points_done; };
    std::vector<std::int64_t> mine;
    const Summary summary = farm_.map(
        batches,
        [&](const Batch& batch, Heartbeat& heartbeat) {
            mine.push_back(batch.points.front());
            const auto give_up = Clock::now() + std::chrono::seconds(30);
            while (batch.points.front() == 0 && done < 199 && Clock::now() < give_up)
                heartbeat.beat();
            return all_completed(batch);
        },
        options);
    if (world_.rank() == 0) {
        EXPECT_EQ(done, 200) << "the last call reports that all is done";
        EXPECT_EQ(mine, std::vector<std::int64_t>{0});
    }
    EXPECT_EQ(summary.points_completed, 200);
}

TEST_F(FarmMap, StopsRanksWithDifferentLists) {
    if (world_.size() == 1)
        GTEST_SKIP() << "one rank agrees with itself";
    for (const std::int64_t other : {0, 9, 11}) {
        const bool is_odd_one = world_.rank() == world_.size() - 1;
        const Summary summary =
            farm_.map(equal_batches(is_odd_one ? other : 10, 1),
                      [](const Batch& batch, Heartbeat&) { return all_completed(batch); });
        EXPECT_EQ(summary.failure, "rank " + std::to_string(world_.size() - 1) +
                                       " holds another list of batches than rank 0");
    }
}

} // namespace
} // namespace culm::farm
