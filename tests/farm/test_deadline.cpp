// SPDX-License-Identifier: BSD-3-Clause
// A batch that would end after the deadline is not begun. Every rank has a clock that only its own
// work advances, so the tests do not depend on the speed of the machine.
#include "farm_fixture.hpp"

#include <algorithm>

namespace culm::farm {
namespace {

class FarmDeadline : public FarmTest {
  protected:
    /// Batches of one point each with these costs.
    [[nodiscard]] static std::vector<Batch> batches_of(const std::vector<double>& costs) {
        std::vector<Batch> batches;
        for (const double cost : costs)
            batches.push_back({{static_cast<std::int64_t>(batches.size())}, cost});
        return batches;
    }

    [[nodiscard]] FarmOptions until(double deadline) {
        FarmOptions options;
        options.chunk_seconds = 0.0;
        options.seconds_per_cost = 1.0;
        options.now = [this] { return time_; };
        options.deadline = Clock::time_point() + seconds(deadline);
        return options;
    }

    [[nodiscard]] static Clock::duration seconds(double count) {
        return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(count));
    }

    /// A batch takes `seconds_per_cost` times its cost on this rank's clock.
    [[nodiscard]] Summary compute(Farm& farm, const std::vector<Batch>& batches,
                                  const FarmOptions& options, double seconds_per_cost) {
        return farm.map(
            batches,
            [&, seconds_per_cost](const Batch& batch, Heartbeat& heartbeat) {
                heartbeat.beat();
                mine_.push_back(batch.points.front());
                time_ += seconds(seconds_per_cost * batch.cost);
                EXPECT_LE(time_, *options.deadline) << "a batch was begun that could not end";
                return all_completed(batch);
            },
            options);
    }

    Clock::time_point time_{};
    std::vector<std::int64_t> mine_;
    Farm alone_;
};

TEST_F(FarmDeadline, SkipsABatchThatWouldEndTooLateForAShorterOne) {
    // After 5 s of 6.5 s: 3 and 2 s do not fit, 1 s does.
    const Summary summary = compute(alone_, batches_of({5.0, 3.0, 2.0, 1.0, 1.0}), until(6.5), 1.0);
    EXPECT_EQ(mine_, (std::vector<std::int64_t>{0, 3}));
    EXPECT_EQ(summary.points_completed, 2);
    EXPECT_TRUE(summary.stopped_early);
    EXPECT_TRUE(summary.out_of_time);
    EXPECT_TRUE(summary.lost.empty());
}

TEST_F(FarmDeadline, UsesThePaceLearnedFromFinishedBatches) {
    // Batches take twice the expected time: the first takes 6 of 10 s, and only one more fits.
    const Summary summary =
        compute(alone_, batches_of({3.0, 3.0, 1.0, 1.0, 1.0}), until(10.0), 2.0);
    EXPECT_EQ(mine_, (std::vector<std::int64_t>{0, 2}));
    EXPECT_NEAR(summary.pace.mean(), 2.0, 1e-9);
    EXPECT_NEAR(summary.pace.cost, 4.0, 1e-9);
}

TEST_F(FarmDeadline, UsesThePaceOfAnEarlierRunFromTheFirstBatch) {
    FarmOptions options = until(6.0);
    options.pace.learn(1.0, 2.0);
    // A cost of 3 would take 6 s and a margin of a tenth.
    (void)compute(alone_, batches_of({3.0, 3.0, 1.0, 1.0, 1.0}), options, 2.0);
    EXPECT_EQ(mine_, (std::vector<std::int64_t>{2, 3}));
}

TEST_F(FarmDeadline, BeginsNothingWhenNothingFits) {
    const Summary summary = compute(alone_, batches_of({3.0, 2.0}), until(1.0), 1.0);
    EXPECT_TRUE(mine_.empty());
    EXPECT_TRUE(summary.out_of_time);
    EXPECT_FALSE(summary.pace.is_known());
}

TEST_F(FarmDeadline, ChangesNothingWhenItIsFarAway) {
    const Summary summary = compute(alone_, batches_of({3.0, 2.0}), until(1000.0), 1.0);
    EXPECT_EQ(summary.points_completed, 2);
    EXPECT_FALSE(summary.stopped_early);
    EXPECT_FALSE(summary.out_of_time);
}

TEST_F(FarmDeadline, LearnsNothingFromAnInterruptedBatch) {
    FarmOptions options = until(100.0);
    options.stop_interval = std::chrono::milliseconds(0);
    options.poll_interval = std::chrono::microseconds(0);
    const Summary summary = alone_.map(
        batches_of({50.0, 1.0}),
        [&](const Batch&, Heartbeat& heartbeat) {
            time_ = *options.deadline; // the machine is much slower than expected
            heartbeat.beat();
            EXPECT_TRUE(heartbeat.stop_requested());
            return BatchReport{};
        },
        options);
    EXPECT_TRUE(summary.out_of_time);
    EXPECT_EQ(summary.points_completed, 0);
    EXPECT_FALSE(summary.pace.is_known());
}

TEST_F(FarmDeadline, EndsAllRanksAndLosesNothing) {
    std::vector<double> costs;
    for (int k = 0; k < 400; ++k)
        costs.push_back(0.1 + (k * 37 % 101) * 0.05);
    // Some 1000 s of work, 40 s for each rank.
    const Summary summary = compute(farm_, batches_of(costs), until(40.0), 1.5);
    const auto counts = count_everywhere(mine_);
    for (const auto& [point, times] : counts)
        EXPECT_EQ(times, 1) << "point " << point;
    EXPECT_EQ(summary.points_completed, static_cast<std::int64_t>(counts.size()));
    EXPECT_GT(summary.points_completed, 0);
    EXPECT_LT(summary.points_completed, 400);
    EXPECT_TRUE(summary.stopped_early);
    EXPECT_TRUE(summary.out_of_time);
    EXPECT_NEAR(summary.pace.mean(), 1.5, 1e-6);
    expect_same_everywhere(summary);
}

TEST_F(FarmDeadline, IsSentToAllRanksWhenItPassesOnOneFirst) {
    FarmOptions options;
    options.stop_interval = std::chrono::milliseconds(0);
    if (world_.rank() == world_.size() - 1)
        options.deadline = Clock::now() + std::chrono::milliseconds(20);
    const Summary summary = farm_.map(
        batches_of(std::vector<double>(100000, 1.0)),
        [&](const Batch& batch, Heartbeat& heartbeat) {
            spin(0.2, heartbeat);
            return all_completed(batch);
        },
        options);
    EXPECT_TRUE(summary.out_of_time);
    EXPECT_LT(summary.points_completed, 100000);
}

TEST_F(FarmDeadline, LetsTheNextMapRunToItsEnd) {
    (void)compute(farm_, batches_of(std::vector<double>(200, 1.0)), until(10.0), 1.0);
    mine_.clear();
    const Summary summary =
        farm_.map(batches_of(std::vector<double>(50, 1.0)), [&](const Batch& batch, Heartbeat&) {
            mine_.push_back(batch.points.front());
            return all_completed(batch);
        });
    EXPECT_EQ(summary.points_completed, 50);
    expect_each_once(count_everywhere(mine_), 50);
}

} // namespace
} // namespace culm::farm
