// SPDX-License-Identifier: BSD-3-Clause
// A silent rank is given up without harm to the others, and takes part again when it responds.
#include "farm_fixture.hpp"

#include <thread>

namespace culm::farm {
namespace {

class FarmSilence : public FarmTest {
  protected:
    FarmSilence() { options_.silence_until_dead = std::chrono::milliseconds(500); }

    /// The last rank sends no heartbeat in its first batch for six times the patience of rank 0.
    Work work_with_a_silent_rank(std::vector<std::int64_t>& mine) {
        return [this, &mine](const Batch& batch, Heartbeat& heartbeat) {
            if (world_.rank() == world_.size() - 1 && mine.empty())
                std::this_thread::sleep_for(6 * options_.silence_until_dead);
            spin(0.1, heartbeat);
            mine.push_back(batch.points.front());
            return all_completed(batch);
        };
    }

    FarmOptions options_;
};

TEST_F(FarmSilence, LosesOnlyTheRunningWorkOfASilentRank) {
    std::vector<std::int64_t> mine;
    const Summary summary =
        farm_.map(equal_batches(60, 1), work_with_a_silent_rank(mine), options_);
    // A busy machine may silence healthy ranks too, so more than one batch may be lost.
    ASSERT_GE(summary.lost.size(), 1U);
    const int silent = world_.size() - 1;
    bool is_named = false;
    for (const LostBatch& lost : summary.lost)
        is_named = is_named || lost.reason == "rank " + std::to_string(silent) + " fell silent";
    EXPECT_TRUE(is_named);
    EXPECT_EQ(summary.points_completed + summary.points_lost, 60);
    EXPECT_EQ(count_everywhere(mine).size(), 60U) << "the silent rank still finished its batch";
    expect_same_everywhere(summary);
}

TEST_F(FarmSilence, LetsALostRankTakePartInTheFollowingMaps) {
    std::vector<std::int64_t> mine;
    (void)farm_.map(equal_batches(20, 1), work_with_a_silent_rank(mine), options_);
    for (int i = 0; i < 5; ++i) {
        mine.clear();
        const Summary summary = farm_.map(
            equal_batches(40, 1),
            [&](const Batch& batch, Heartbeat& heartbeat) {
                spin(1.0, heartbeat);
                mine.push_back(batch.points.front());
                return all_completed(batch);
            },
            options_);
        EXPECT_EQ(summary.points_completed + summary.points_lost, 40);
        EXPECT_EQ(count_everywhere(mine).size(), 40U);
    }
}

} // namespace
} // namespace culm::farm
