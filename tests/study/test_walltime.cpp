// SPDX-License-Identifier: BSD-3-Clause
// A study with a deadline computes the batches that fit, passes its pace to the next run, and loses
// no point. On the simulated clock every point takes one second.
#include "archive/study/file.hpp"
#include "run/simulate.hpp"
#include "small_studies.hpp"
#include "study/execute/execute.hpp"
#include "study/execute/journal_notes.hpp"
#include "study/execute/point_results.hpp"
#include "support/temporary_folder.hpp"

#include <fstream>

#include <gtest/gtest.h>

namespace culm::study {
namespace {

class StudyWalltime : public ::testing::Test {
  protected:
    [[nodiscard]] ExecuteOutcome run_for(std::optional<double> seconds) {
        using farm::Clock;
        ExecuteOptions options;
        options.folder.resume = true;
        options.farm.now = [this] { return time; };
        if (seconds)
            options.farm.deadline = time + std::chrono::duration_cast<Clock::duration>(
                                               std::chrono::duration<double>(*seconds));
        options.compute_point = [this](const run::CaseSpec& spec) {
            time += std::chrono::seconds(1);
            archive::PointRecord record;
            record.point = spec.point;
            record.completed = true;
            record.values.assign(result_columns(study.config).size(), double(spec.point));
            record.tip_deflection.assign(study.config.base.sample_count(), 1e-3);
            return record;
        };
        return execute(study, folder, nullptr, options);
    }

    tests::TemporaryFolder above;
    StudyFolder folder{above / "study"};
    // There are at least three batches; the last one is partly empty.
    Study study =
        parse_study(small::explicit_study + "bond_youngs_modulus_gpa = [1, 1.1]\n", "s.toml");
    std::int64_t points = study.design.point_count();
    std::int64_t lanes = static_cast<std::int64_t>(run::lanes_per_batch());
    farm::Clock::time_point time{};
};

TEST_F(StudyWalltime, BeginsNoBatchThatWouldEndTooLate) {
    // The time for half a batch remains after the first two.
    const ExecuteOutcome outcome = run_for(2.5 * double(lanes));
    EXPECT_EQ(outcome.farm.points_completed, 2 * lanes);
    EXPECT_TRUE(outcome.farm.out_of_time);
    EXPECT_FALSE(outcome.archive_is_complete);
}

TEST_F(StudyWalltime, KnowsThePaceOfEarlierRuns) {
    (void)run_for(2.5 * double(lanes));
    ASSERT_TRUE(read_pace(folder).is_known());
    // The estimate for the reference machine is far below a second; the pace is 1 s per point.
    const ExecuteOutcome outcome = run_for(0.5 * double(lanes));
    EXPECT_EQ(outcome.farm.points_completed, 0);
    EXPECT_TRUE(outcome.farm.out_of_time);
    EXPECT_GT(outcome.shortest_batch_s, 0.5 * double(lanes));
    EXPECT_EQ(outcome.resumed_points, 2 * lanes);
}

TEST_F(StudyWalltime, IsCompletedRunByRun) {
    std::int64_t computed = 0;
    int runs = 0;
    ExecuteOutcome outcome;
    do {
        outcome = run_for(1.5 * double(lanes));
        computed += outcome.farm.points_completed;
        ASSERT_LT(++runs, 20);
    } while (!outcome.archive_is_complete);
    EXPECT_EQ(computed, points) << "no point twice";
    EXPECT_GT(runs, 1);
    EXPECT_FALSE(outcome.farm.out_of_time);
    EXPECT_FALSE(std::filesystem::exists(folder.journals()));
}

TEST_F(StudyWalltime, IgnoresADamagedNoteOfThePace) {
    (void)run_for(1.5 * double(lanes));
    for (const char* text : {"", "{", "[]", R"({"format": "culm-pace"})", R"({"format": 3})",
                             R"({"format": "culm-pace", "estimated_seconds": 1e999, "seconds": 1,
              "seconds_squared_per_estimated_second": 1})",
                             R"({"format": "culm-pace", "estimated_seconds": "x", "seconds": 1,
              "seconds_squared_per_estimated_second": 1})"}) {
        std::ofstream(folder.pace()) << text;
        EXPECT_FALSE(read_pace(folder).is_known()) << text;
    }
    EXPECT_TRUE(run_for(std::nullopt).archive_is_complete);
}

} // namespace
} // namespace culm::study
