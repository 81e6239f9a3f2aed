// SPDX-License-Identifier: BSD-3-Clause
// The farm of one rank works in a program that never initialises MPI.
#include "core/error.hpp"
#include "farm/batch.hpp"
#include "farm/farm.hpp"

#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

namespace culm::farm {
namespace {

std::vector<Batch> three_batches() {
    return {{{0, 1}, 1.0}, {{2}, 3.0}, {{3, 4, 5}, 2.0}};
}

TEST(SerialFarm, ComputesTheLongestFirstAndSumsTheReports) {
    std::vector<std::int64_t> first_points;
    const Summary summary =
        Farm().map(three_batches(), [&](const Batch& batch, Heartbeat& heartbeat) {
            heartbeat.beat();
            first_points.push_back(batch.points.front());
            return BatchReport{static_cast<std::int64_t>(batch.points.size()) - 1, 1, 0.5};
        });
    EXPECT_EQ(first_points, (std::vector<std::int64_t>{2, 3, 0}));
    EXPECT_EQ(summary.points_total, 6);
    EXPECT_EQ(summary.points_completed, 3);
    EXPECT_EQ(summary.points_failed, 3);
    EXPECT_DOUBLE_EQ(summary.work_s, 1.5);
    EXPECT_FALSE(summary.stopped_early);
    EXPECT_TRUE(summary.failure.empty());
    EXPECT_EQ(summary.ranks, 1);
}

TEST(SerialFarm, ComputesEveryBatchOnceWhenAllCostsAreZero) {
    std::vector<Batch> batches;
    for (std::int64_t point = 0; point < 1000; ++point)
        batches.push_back({{point}, 0.0});
    std::vector<int> times(batches.size());
    const Summary summary = Farm().map(batches, [&](const Batch& batch, Heartbeat&) {
        ++times[static_cast<std::size_t>(batch.points.front())];
        return BatchReport{1, 0, 0.0};
    });
    EXPECT_EQ(times, std::vector<int>(1000, 1));
    EXPECT_EQ(summary.points_completed, 1000);
}

TEST(SerialFarm, ComputesNothingAfterADeadline) {
    FarmOptions options;
    options.deadline = Clock::now();
    const Summary summary = Farm().map(
        three_batches(),
        [](const Batch&, Heartbeat&) -> BatchReport { throw std::logic_error("ran"); }, options);
    EXPECT_TRUE(summary.stopped_early);
    EXPECT_TRUE(summary.lost.empty());
    EXPECT_EQ(summary.points_completed, 0);
}

TEST(SerialFarm, DoesNotCallAStopAfterTheLastPointEarly) {
    bool is_stop = false;
    FarmOptions options;
    options.stop_interval = std::chrono::milliseconds(0);
    options.poll_interval = std::chrono::microseconds(0);
    options.stop_requested = [&] { return is_stop; };
    const Summary summary = Farm().map(
        std::vector<Batch>{{{1}, 1.0}},
        [&](const Batch&, Heartbeat& heartbeat) {
            is_stop = true;
            heartbeat.beat();
            EXPECT_TRUE(heartbeat.stop_requested());
            return BatchReport{1, 0, 0.0};
        },
        options);
    EXPECT_FALSE(summary.stopped_early);
}

TEST(SerialFarm, LetsWorkLeaveItsBatchWhenAStopIsRequested) {
    FarmOptions options;
    bool is_stop = false;
    options.stop_interval = std::chrono::milliseconds(0);
    options.poll_interval = std::chrono::microseconds(0);
    options.stop_requested = [&] { return is_stop; };
    const Summary summary = Farm().map(
        std::vector<Batch>{{{1, 2, 3}, 1.0}},
        [&](const Batch&, Heartbeat& heartbeat) {
            is_stop = true;
            while (!heartbeat.stop_requested())
                heartbeat.beat();
            return BatchReport{1, 0, 0.0};
        },
        options);
    EXPECT_TRUE(summary.stopped_early);
    EXPECT_EQ(summary.points_completed, 1);
}

TEST(SerialFarm, ListsABatchThatThrowsNoStdExceptionAsLost) {
    const Summary summary = Farm().map(std::vector<Batch>{{{1}, 1.0}},
                                       [](const Batch&, Heartbeat&) -> BatchReport { throw 7; });
    ASSERT_EQ(summary.lost.size(), 1U);
    EXPECT_EQ(summary.lost[0].reason,
              "the work function threw something that is not a std::exception");
}

TEST(SerialFarm, StopsWhenTheProgressFunctionThrows) {
    FarmOptions options;
    options.progress_interval = std::chrono::milliseconds(0);
    options.progress = [](const Progress&) { throw core::StorageError("no space for the log"); };
    const Summary summary = Farm().map(
        three_batches(), [](const Batch&, Heartbeat&) { return BatchReport{}; }, options);
    EXPECT_EQ(summary.failure, "rank 0: no space for the log");
    EXPECT_TRUE(summary.stopped_early);
}

TEST(SerialFarm, CountsPointsStoredBeforeTheDiskWasFull) {
    const std::vector<Batch> batches = {{{0, 1, 2, 3}, 1.0}, {{4}, 1.0}};
    const Summary summary = Farm().map(batches, [](const Batch&, Heartbeat&) {
        BatchReport report;
        report.completed = 3;
        report.storage_failure = "no space left on device";
        return report;
    });
    EXPECT_EQ(summary.points_completed, 3);
    EXPECT_EQ(summary.failure, "rank 0: no space left on device");
    EXPECT_TRUE(summary.stopped_early);
}

TEST(SerialFarm, EndsItsProgressWithAllPointsAndNoRemainingTime) {
    std::vector<Progress> seen;
    FarmOptions options;
    options.progress_interval = std::chrono::milliseconds(0);
    options.poll_interval = std::chrono::microseconds(0);
    options.progress = [&](const Progress& progress) { seen.push_back(progress); };
    (void)Farm().map(
        three_batches(),
        [](const Batch& batch, Heartbeat&) {
            return BatchReport{static_cast<std::int64_t>(batch.points.size()), 0, 0.0};
        },
        options);
    ASSERT_GE(seen.size(), 2U);
    EXPECT_EQ(seen.front().points_done, 0);
    EXPECT_FALSE(seen.front().estimated_remaining_s.has_value());
    EXPECT_EQ(seen.back().points_done, 6);
    EXPECT_EQ(seen.back().points_total, 6);
    ASSERT_TRUE(seen.back().estimated_remaining_s.has_value());
    EXPECT_EQ(*seen.back().estimated_remaining_s, 0.0);
}

TEST(SerialFarm, RefusesAnInvalidCost) {
    EXPECT_THROW(
        (void)Farm().map(std::vector<Batch>{{{1}, std::numeric_limits<double>::quiet_NaN()}},
                         [](const Batch&, Heartbeat&) { return BatchReport{}; }),
        FarmError);
}

TEST(Heartbeat, NeverRequestsAStopOutsideAFarm) {
    Heartbeat heartbeat;
    heartbeat.beat();
    EXPECT_FALSE(heartbeat.stop_requested());
}

} // namespace
} // namespace culm::farm
