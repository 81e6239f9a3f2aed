// SPDX-License-Identifier: BSD-3-Clause
// A stop on any rank, and an error that concerns all, ends the farm everywhere in good order.
#include "core/error.hpp"
#include "farm_fixture.hpp"

#include <stdexcept>

namespace culm::farm {
namespace {

/// This number of batches of 0.2 ms takes far longer than the detection of a stop.
constexpr std::int64_t endless = 200000;

class FarmStop : public FarmTest {
  protected:
    [[nodiscard]] int last_rank() const { return world_.size() - 1; }

    /// Completed points of the summary are those that were computed, each once. Collective.
    void expect_orderly(const Summary& summary, const std::vector<std::int64_t>& mine) const {
        const auto counts = count_everywhere(mine);
        for (const auto& [point, times] : counts)
            EXPECT_EQ(times, 1) << "point " << point;
        EXPECT_EQ(summary.points_completed, static_cast<std::int64_t>(counts.size()));
        EXPECT_LT(summary.points_completed, summary.points_total);
        EXPECT_TRUE(summary.stopped_early);
        expect_same_everywhere(summary);
    }
};

TEST_F(FarmStop, EndsAllRanksWhenTheLastRankRequestsIt) {
    std::vector<std::int64_t> mine;
    FarmOptions options;
    options.stop_requested = [&] { return world_.rank() == last_rank() && mine.size() >= 20; };
    const Summary summary = farm_.map(
        equal_batches(endless, 1),
        [&](const Batch& batch, Heartbeat& heartbeat) {
            spin(0.2, heartbeat);
            mine.push_back(batch.points.front());
            return all_completed(batch);
        },
        options);
    expect_orderly(summary, mine);
    EXPECT_TRUE(summary.failure.empty());
    EXPECT_GE(count_everywhere(mine).size(), 20U) << "nothing stops before the request";
}

TEST_F(FarmStop, ReachesWorkInProgressOnEveryRankFromTheLastOne) {
    // No batch ends before the stop has reached it.
    FarmOptions options;
    bool has_begun = false;
    options.stop_requested = [&] { return world_.rank() == last_rank() && has_begun; };
    std::vector<std::int64_t> mine;
    const Summary summary = farm_.map(
        equal_batches(1000, 2),
        [&](const Batch& batch, Heartbeat& heartbeat) {
            has_begun = true;
            while (!heartbeat.stop_requested())
                heartbeat.beat();
            mine.push_back(batch.points.front());
            return BatchReport{1, 0, 0.0};
        },
        options);
    expect_orderly(summary, mine);
    EXPECT_LE(mine.size(), 1U);
}

TEST_F(FarmStop, EndsAllRanksAtTheDeadline) {
    std::vector<std::int64_t> mine;
    FarmOptions options;
    // Only rank 0 has the deadline: the others must learn of it by message.
    if (world_.rank() == 0)
        options.deadline = Clock::now() + std::chrono::milliseconds(50);
    const Summary summary = farm_.map(
        equal_batches(endless, 1),
        [&](const Batch& batch, Heartbeat& heartbeat) {
            spin(0.2, heartbeat);
            mine.push_back(batch.points.front());
            return all_completed(batch);
        },
        options);
    expect_orderly(summary, mine);
}

TEST_F(FarmStop, FollowsAStorageErrorOnOneRankAndItsTextReachesAll) {
    for (const int culprit : {0, last_rank()}) {
        std::vector<std::int64_t> mine;
        const Summary summary =
            farm_.map(equal_batches(endless, 1), [&](const Batch& batch, Heartbeat& heartbeat) {
                spin(0.2, heartbeat);
                if (world_.rank() == culprit && mine.size() == 10)
                    throw core::StorageError("no space left on device");
                mine.push_back(batch.points.front());
                return all_completed(batch);
            });
        expect_orderly(summary, mine);
        EXPECT_EQ(summary.failure, "rank " + std::to_string(culprit) + ": no space left on device");
        ASSERT_EQ(summary.lost.size(), 1U);
        EXPECT_EQ(summary.lost[0].rank, culprit);
    }
}

TEST_F(FarmStop, FollowsAStopFunctionThatThrowsAndItsTextReachesAll) {
    std::vector<std::int64_t> mine;
    FarmOptions options;
    options.stop_requested = [&]() -> bool {
        if (world_.rank() == last_rank())
            throw std::runtime_error("the stop file cannot be read");
        return false;
    };
    const Summary summary = farm_.map(
        equal_batches(endless, 1),
        [&](const Batch& batch, Heartbeat& heartbeat) {
            spin(0.2, heartbeat);
            mine.push_back(batch.points.front());
            return all_completed(batch);
        },
        options);
    expect_orderly(summary, mine);
    EXPECT_EQ(summary.failure,
              "rank " + std::to_string(last_rank()) + ": the stop file cannot be read");
}

TEST_F(FarmStop, LetsTheNextMapRunToItsEnd) {
    for (int i = 0; i < 20; ++i) {
        FarmOptions stopping;
        stopping.stop_requested = [] { return true; };
        const auto work = [](const Batch& batch, Heartbeat&) { return all_completed(batch); };
        EXPECT_TRUE(farm_.map(equal_batches(endless / 10, 1), work, stopping).stopped_early);
        EXPECT_EQ(farm_.map(equal_batches(50, 1), work).points_completed, 50);
    }
}

} // namespace
} // namespace culm::farm
