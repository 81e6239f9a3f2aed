// SPDX-License-Identifier: BSD-3-Clause
// The scheduling decisions alone, driven without MPI.
#include "farm/scheduler.hpp"

#include <algorithm>
#include <numeric>
#include <queue>
#include <tuple>

#include <gtest/gtest.h>

namespace culm::farm {
namespace {

constexpr double one_by_one = 0.0;

/// Simulates a map: every rank takes cost · `seconds_per_cost` for a batch. Returns how often each
/// batch was computed; `makespan` is the time at which the last rank finished.
struct PaperFarm {
    std::vector<double> costs;
    int ranks;
    double chunk_seconds;
    double seconds_per_cost;
    double makespan = 0.0;
    std::int64_t ranges = 0;

    std::vector<int> play() {
        Scheduler scheduler(costs, ranks, chunk_seconds);
        std::vector<int> times(costs.size(), 0);
        using Event = std::tuple<double, int>; // end of a range, rank
        std::priority_queue<Event, std::vector<Event>, std::greater<>> events;
        std::vector<bool> is_busy(static_cast<std::size_t>(ranks), false);
        double now = 0.0;
        const auto begin = [&](int rank) {
            if (scheduler.held_by(rank).empty() || is_busy[static_cast<std::size_t>(rank)])
                return;
            is_busy[static_cast<std::size_t>(rank)] = true;
            events.emplace(now + seconds(scheduler.held_by(rank).front()), rank);
        };
        scheduler.deal();
        for (int rank = 0; rank < ranks; ++rank)
            begin(rank);
        while (!events.empty()) {
            const auto [time, rank] = events.top();
            events.pop();
            now = time;
            is_busy[static_cast<std::size_t>(rank)] = false;
            const Range range = scheduler.held_by(rank).front();
            ++ranges;
            for (std::int64_t place = range.first; place < range.first + range.count; ++place)
                ++times[static_cast<std::size_t>(place)];
            EXPECT_TRUE(scheduler.report(rank, range, range.count, seconds(range)));
            while (scheduler.hand_out(rank)) {
            }
            begin(rank);
        }
        EXPECT_TRUE(scheduler.is_finished());
        makespan = now;
        return times;
    }

    [[nodiscard]] double seconds(Range range) const {
        const auto first = costs.begin() + range.first;
        return seconds_per_cost * std::accumulate(first, first + range.count, 0.0);
    }
};

std::vector<double> falling_costs(int count) {
    std::vector<double> costs(static_cast<std::size_t>(count));
    std::iota(costs.rbegin(), costs.rend(), 1.0);
    return costs;
}

TEST(Scheduler, HandsOutEveryBatchExactlyOnce) {
    for (const int ranks : {1, 2, 3, 17, 1000})
        for (const int batches : {0, 1, 2, 16, 17, 18, 999, 5000})
            for (const double chunk_seconds : {one_by_one, 0.01, 1e9}) {
                PaperFarm farm{falling_costs(batches), ranks, chunk_seconds, 1e-6};
                const std::vector<int> times = farm.play();
                EXPECT_EQ(std::count(times.begin(), times.end(), 1), batches)
                    << ranks << " ranks, chunks of " << chunk_seconds << " s";
            }
}

TEST(Scheduler, HandsOutInTheOrderOfThePlan) {
    Scheduler scheduler(falling_costs(10), 1, one_by_one);
    for (std::int64_t place = 0; place < 10; ++place) {
        const auto range = scheduler.hand_out(0);
        ASSERT_EQ(range, (Range{place, 1}));
        ASSERT_TRUE(scheduler.report(0, *range, 1, 1.0));
    }
    EXPECT_TRUE(scheduler.is_finished());
}

TEST(Scheduler, DealsToEveryRankBeforeAnyGetsASecondRange) {
    Scheduler scheduler(falling_costs(20), 3, one_by_one);
    scheduler.deal();
    EXPECT_EQ(scheduler.held_by(0).front(), (Range{0, 1}));
    EXPECT_EQ(scheduler.held_by(1).front(), (Range{1, 1}));
    EXPECT_EQ(scheduler.held_by(2).front(), (Range{2, 1}));
    EXPECT_EQ(scheduler.held_by(0).size(), 1U) << "rank 0 sits next to the list";
    EXPECT_EQ(scheduler.held_by(1).size(), 2U);
    EXPECT_EQ(scheduler.held_by(2).size(), 2U);
    EXPECT_EQ(scheduler.remaining(), 15);
}

TEST(Scheduler, NeverGivesARankMoreThanOneRangeAhead) {
    Scheduler scheduler(falling_costs(100), 2, one_by_one);
    EXPECT_TRUE(scheduler.hand_out(1));
    EXPECT_TRUE(scheduler.hand_out(1));
    EXPECT_FALSE(scheduler.hand_out(1));
    EXPECT_TRUE(scheduler.hand_out(0));
    EXPECT_FALSE(scheduler.hand_out(0));
}

TEST(Scheduler, DoesNotPrefetchWhenFewerBatchesRemainThanRanks) {
    // 4 ranks: after the opening hand of 4 batches 3 remain.
    Scheduler scheduler(falling_costs(7), 4, one_by_one);
    scheduler.deal();
    for (int rank = 0; rank < 4; ++rank) {
        EXPECT_EQ(scheduler.held_by(rank).size(), 1U);
        EXPECT_FALSE(scheduler.hand_out(rank));
    }
    // But an idle rank gets one.
    ASSERT_TRUE(scheduler.report(2, {2, 1}, 1, 1.0));
    EXPECT_EQ(scheduler.hand_out(2), (Range{4, 1}));
}

TEST(Scheduler, GivesTheLastBatchToTheRankThatIsFreeFirst) {
    // Queued behind one of the long batches it would end after 6 s.
    PaperFarm farm{{5.0, 5.0, 1.0, 1.0}, 3, 0.01, 1.0};
    (void)farm.play();
    EXPECT_DOUBLE_EQ(farm.makespan, 5.0);
}

TEST(Scheduler, EndsEqualBatchesThatDivideEvenlyOnAllRanksTogether) {
    for (const int ranks : {2, 4, 8}) {
        for (const int rounds : {1, 2, 3, 10}) {
            const auto batches = static_cast<std::size_t>(rounds) * static_cast<std::size_t>(ranks);
            PaperFarm farm{std::vector<double>(batches, 1.0), ranks, 0.01, 1.0};
            (void)farm.play();
            EXPECT_DOUBLE_EQ(farm.makespan, rounds) << ranks << " ranks";
        }
    }
}

TEST(Scheduler, KeepsWithinOnePrefetchedBatchOfTheListSchedulingBound) {
    // Graham (1969): without prefetch at most (sum - longest) / ranks + longest. A prefetched batch
    // may start later by at most the one in front of it, which is no longer than the longest.
    const int ranks = 16;
    PaperFarm farm{falling_costs(300), ranks, 0.01, 1.0};
    (void)farm.play();
    const double sum = 300.0 * 301.0 / 2.0;
    EXPECT_LE(farm.makespan, (sum - 300.0) / ranks + 2.0 * 300.0);
    EXPECT_GE(farm.makespan, sum / ranks);
}

TEST(Scheduler, HandsOutLongBatchesOneByOne) {
    PaperFarm farm{std::vector<double>(500, 1.0), 4, 0.01, 0.02};
    (void)farm.play();
    EXPECT_EQ(farm.ranges, 500);
}

TEST(Scheduler, HandsOutTinyBatchesManyAtATime) {
    // 1e5 batches of 1 µs, ranges of up to 10 ms: guided ranges shrink by the factor 1 - 1/(2
    // ranks), which takes some 4 ln(1e5) = 46 ranges, and the last 2 · ranks batches go one by one.
    PaperFarm farm{std::vector<double>(100000, 1.0), 2, 0.01, 1e-6};
    (void)farm.play();
    EXPECT_LT(farm.ranges, 100);
    EXPECT_GT(farm.ranges, 10);
}

TEST(Scheduler, LimitsTheTimeOfARangeOfTinyBatches) {
    Scheduler scheduler(std::vector<double>(100000, 1.0), 1, 0.01);
    const auto first = scheduler.hand_out(0);
    ASSERT_EQ(first, (Range{0, 1}));
    ASSERT_TRUE(scheduler.report(0, *first, 1, 1e-4));
    EXPECT_EQ(scheduler.hand_out(0), (Range{1, 100}));
}

TEST(Scheduler, ShrinksRangesTowardsTheTail) {
    // Work that takes no time at all: only the guided share limits the ranges.
    Scheduler scheduler(std::vector<double>(1000, 1.0), 2, 0.01);
    std::int64_t last = 1000;
    auto range = scheduler.hand_out(0);
    ASSERT_TRUE(scheduler.report(0, *range, range->count, 0.0));
    while ((range = scheduler.hand_out(0))) {
        EXPECT_LE(range->count, last);
        EXPECT_LE(range->count, std::max<std::int64_t>(1, (1000 - range->first) / 4));
        last = range->count;
        ASSERT_TRUE(scheduler.report(0, *range, range->count, 0.0));
    }
    EXPECT_EQ(last, 1);
}

TEST(Scheduler, StartsWithLongRangesWhenTheCostIsKnownInSeconds) {
    // 2 ranks, batches of 1 ms, ranges of 10 ms.
    Scheduler scheduler(std::vector<double>(1000, 1.0), 2, 0.01, 1e-3);
    scheduler.deal();
    EXPECT_EQ(scheduler.held_by(0).front().count, 10);
    EXPECT_EQ(scheduler.held_by(1).front().count, 10);
    // Reports outweigh the expected cost: batches take 10 ms.
    ASSERT_TRUE(scheduler.report(0, {0, 10}, 10, 0.1));
    EXPECT_EQ(scheduler.hand_out(0)->count, 1);
}

TEST(Scheduler, KeepsLongBatchesSingleWhenTheCostIsKnownInSeconds) {
    Scheduler scheduler(std::vector<double>(1000, 0.1), 2, 0.01, 1.0);
    scheduler.deal();
    for (const int rank : {0, 1})
        EXPECT_EQ(scheduler.held_by(rank).front().count, 1);
}

TEST(Scheduler, LimitsTheReportsOfManyRanksToWhatRank0CanAnswer) {
    // 4096 ranks, 400 000 batches of 10 ms: one by one 409 600 reports per second.
    const int ranks = 4096;
    PaperFarm farm{std::vector<double>(400'000, 1.0), ranks, 0.01, 0.01};
    (void)farm.play();
    // A range may take 4096 * 50 µs = 0.2 s, 20 batches; the opening hand and the ranges that halve
    // towards the end give 7 on average. The test asks for 5, to show that the rule acts.
    EXPECT_LT(farm.ranges, 400'000 / 5);
    // And no rank waits for it: 97.7 batches for each rank, one more at the end.
    EXPECT_LE(farm.makespan, 0.01 * (400'000.0 / ranks + 2.0));
}

TEST(Scheduler, HandsOutNothingAfterAStop) {
    Scheduler scheduler(falling_costs(10), 2, one_by_one);
    scheduler.deal();
    scheduler.stop();
    EXPECT_FALSE(scheduler.is_finished()) << "ranges are still in progress";
    ASSERT_TRUE(scheduler.report(0, {0, 1}, 1, 1.0));
    EXPECT_FALSE(scheduler.hand_out(0));
    ASSERT_TRUE(scheduler.report(1, {1, 1}, 1, 1.0));
    ASSERT_TRUE(scheduler.report(1, {2, 1}, 0, 0.0)) << "queued, never begun";
    EXPECT_FALSE(scheduler.hand_out(1));
    EXPECT_TRUE(scheduler.is_finished());
    EXPECT_EQ(scheduler.remaining(), 8);
    EXPECT_DOUBLE_EQ(scheduler.finished_cost(), 10.0 + 9.0);
}

TEST(Scheduler, TakesBackAllFromARankThatNeverBegan) {
    Scheduler scheduler(falling_costs(10), 2, one_by_one);
    scheduler.deal();
    scheduler.withdraw(1);
    EXPECT_TRUE(scheduler.held_by(1).empty());
    EXPECT_EQ(scheduler.remaining(), 9);
}

TEST(Scheduler, IgnoresAReportOfARangeThatTheRankDoesNotHold) {
    Scheduler scheduler(falling_costs(10), 2, one_by_one);
    scheduler.deal();
    EXPECT_FALSE(scheduler.report(1, {0, 1}, 1, 1.0)) << "held by rank 0";
    EXPECT_FALSE(scheduler.report(0, {0, 2}, 2, 1.0)) << "no such range";
    EXPECT_DOUBLE_EQ(scheduler.finished_cost(), 0.0);
}

TEST(Scheduler, SkipsBatchesAboveTheLimitForShorterOnes) {
    Scheduler scheduler({{5.0, 4.0, 3.0, 2.0, 1.0}}, 1, one_by_one);
    const auto range = scheduler.hand_out(0, 3.5);
    EXPECT_EQ(range, (Range{2, 1}));
    EXPECT_EQ(scheduler.remaining(), 4) << "skipped batches are still to be done";
    ASSERT_TRUE(scheduler.report(0, *range, 1, 1.0));
    EXPECT_EQ(scheduler.hand_out(0, 0.5), std::nullopt);
    EXPECT_TRUE(scheduler.is_idle());
    EXPECT_FALSE(scheduler.is_finished());
}

TEST(Scheduler, HandsOutSkippedBatchesWhenTheLimitRisesAgain) {
    Scheduler scheduler({{5.0, 4.0, 3.0, 2.0, 1.0}}, 1, one_by_one);
    ASSERT_EQ(scheduler.hand_out(0, 0.5), std::nullopt);
    std::vector<std::int64_t> places;
    while (const auto range = scheduler.hand_out(0, 4.0)) {
        ASSERT_EQ(range->count, 1);
        places.push_back(range->first);
        ASSERT_TRUE(scheduler.report(0, *range, 1, 1.0));
    }
    EXPECT_EQ(places, (std::vector<std::int64_t>{4, 3, 2, 1}));
    EXPECT_EQ(scheduler.remaining(), 1);
}

TEST(Scheduler, LimitsTheCostOfARange) {
    // 1000 batches of 1 ms, ranges of 10 ms.
    Scheduler scheduler(std::vector<double>(1000, 1.0), 1, 0.01, 1e-3);
    EXPECT_EQ(scheduler.hand_out(0, 4.5), (Range{0, 4}));
    // A range that is returned is cut to the limit too, and none of it is lost.
    ASSERT_TRUE(scheduler.report(0, {0, 4}, 0, 0.0));
    EXPECT_EQ(scheduler.hand_out(0, 2.0), (Range{0, 2}));
    ASSERT_TRUE(scheduler.report(0, {0, 2}, 2, 0.0));
    EXPECT_EQ(scheduler.hand_out(0, 9.0), (Range{2, 2}));
    EXPECT_EQ(scheduler.remaining(), 996);
}

} // namespace
} // namespace culm::farm
