// SPDX-License-Identifier: BSD-3-Clause
// Points that kill their process are abandoned after some deaths; failed ones can be retried.
#include "archive/journal/read.hpp"
#include "archive/study/file.hpp"
#include "core/error.hpp"
#include "small_studies.hpp"
#include "study/execute/execute.hpp"
#include "study/execute/point_results.hpp"
#include "support/temporary_folder.hpp"

#include <algorithm>
#include <csignal>
#include <exception>
#include <map>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

namespace culm::study {
namespace {

using archive::PointStatus;

constexpr std::int64_t deadly_point = 4;

class CrashLimit : public ::testing::Test {
  protected:
    [[nodiscard]] archive::PointRecord answer(const run::CaseSpec& spec) const {
        archive::PointRecord record;
        record.point = spec.point;
        record.completed = true;
        record.values.assign(result_columns(study.config).size(), double(spec.point));
        record.tip_deflection.assign(study.config.base.sample_count(), 1e-3);
        return record;
    }
    [[nodiscard]] ExecuteOptions options(int crash_limit) const {
        ExecuteOptions result;
        result.folder.resume = true;
        result.folder.crash_limit = crash_limit;
        result.compute_point = [this](const run::CaseSpec& spec) { return answer(spec); };
        return result;
    }
    /// Executes in a child process, which dies by SIGKILL when it reaches the deadly point. Returns
    /// true if it died.
    [[nodiscard]] bool dies(ExecuteOptions deadly) const {
        const pid_t child = ::fork();
        if (child == 0) {
            deadly.compute_point = [this](const run::CaseSpec& spec) {
                if (spec.point == deadly_point)
                    (void)::raise(SIGKILL);
                return answer(spec);
            };
            try {
                (void)execute(study, folder, nullptr, deadly);
            } catch (const std::exception&) {
                ::_exit(1);
            }
            ::_exit(0);
        }
        int state = 0;
        EXPECT_EQ(::waitpid(child, &state, 0), child);
        EXPECT_TRUE(WIFSIGNALED(state) || WEXITSTATUS(state) == 0);
        return WIFSIGNALED(state) && WTERMSIG(state) == SIGKILL;
    }
    [[nodiscard]] FolderContent content() const {
        return prepare_folder(folder, study.config.identity(), 11, {true, false, 5});
    }

    tests::TemporaryFolder above;
    StudyFolder folder{above / "study"};
    Study study = parse_study(small::explicit_study, "s.toml"); // 11 points
};

TEST_F(CrashLimit, PointThatKillsItsProcessIsGivenUpAndTheOthersComplete) {
    int deaths = 0;
    while (dies(options(3)))
        ASSERT_LE(++deaths, 3);
    EXPECT_EQ(deaths, 3);
    const archive::StudyFile file(folder.archive());
    for (std::int64_t point = 0; point < file.point_count(); ++point)
        EXPECT_EQ(file.status(point),
                  point == deadly_point ? PointStatus::Failed : PointStatus::Completed)
            << point;
    EXPECT_EQ(file.failure_kind(deadly_point), "rank_died");
    EXPECT_EQ(file.failure_reason(deadly_point),
              "the process that computed this point died 3 times (--crash-limit 3); "
              "--retry-failed tries it again");
}

TEST_F(CrashLimit, SuspectsAreComputedAloneSoThatOneDeathTakesNoOthersWithIt) {
    EXPECT_TRUE(dies(options(5)));
    const FolderContent first = content();
    EXPECT_TRUE(std::ranges::binary_search(first.suspect_points, deadly_point));
    const auto batches = make_batches(study, first.pending_points, first.suspect_points);
    for (const farm::Batch& batch : batches)
        for (const std::int64_t point : batch.points)
            if (std::ranges::binary_search(first.suspect_points, point)) {
                EXPECT_EQ(batch.points.size(), 1U);
            }
    EXPECT_TRUE(dies(options(5)));
    EXPECT_TRUE(dies(options(5)));
    // The other points of its first batch have been computed since, or were not started again.
    std::map<std::int64_t, int> deaths;
    for (const auto& scan :
         archive::scan_journal_folder(folder.journals(), study.config.identity()))
        for (const auto& [point, times] : scan.unfinished_starts)
            deaths[point] += times;
    for (const auto& [point, times] : deaths)
        EXPECT_EQ(times, point == deadly_point ? 3 : 1) << point;
}

TEST_F(CrashLimit, NoneMeansThatThePointIsTriedForEver) {
    for (int death = 1; death <= 7; ++death)
        EXPECT_TRUE(dies(options(0))) << death;
    EXPECT_TRUE(execute(study, folder, nullptr, options(0)).archive_is_complete);
    EXPECT_EQ(archive::StudyFile(folder.archive()).status(deadly_point), PointStatus::Completed);
}

TEST_F(CrashLimit, RunThatIsStoppedInOrderCountsAgainstNoPoint) {
    ExecuteOptions stopping = options(1);
    stopping.compute_point = [this](const run::CaseSpec& spec) {
        if (spec.point == deadly_point)
            throw core::StorageError("the disk is full");
        return answer(spec);
    };
    EXPECT_FALSE(execute(study, folder, nullptr, stopping).archive_is_complete);
    EXPECT_TRUE(content().suspect_points.empty());
    EXPECT_TRUE(execute(study, folder, nullptr, options(1)).archive_is_complete);
    EXPECT_EQ(archive::StudyFile(folder.archive()).status(deadly_point), PointStatus::Completed);
}

TEST_F(CrashLimit, RetryFailedComputesFailedPointsAgainAndNothingElse) {
    ASSERT_TRUE(dies(options(1)));
    while (dies(options(1))) {
    }
    ASSERT_EQ(archive::StudyFile(folder.archive()).status(deadly_point), PointStatus::Failed);
    ExecuteOptions retry = options(1);
    EXPECT_EQ(execute(study, folder, nullptr, retry).resumed_points, 11); // not without the option
    retry.folder.retry_failed = true;
    const ExecuteOutcome outcome = execute(study, folder, nullptr, retry);
    std::int64_t failed = 11 - outcome.resumed_points;
    EXPECT_EQ(outcome.farm.points_completed, failed);
    const archive::StudyFile file(folder.archive());
    for (std::int64_t point = 0; point < file.point_count(); ++point) {
        EXPECT_EQ(file.status(point), PointStatus::Completed);
        EXPECT_EQ(file.result("frequency")[std::size_t(point)], double(point));
    }
    EXPECT_FALSE(is_there(folder.journals()));
}

TEST_F(CrashLimit, RetryThatIsInterruptedIsFinishedByAPlainResume) {
    while (dies(options(1))) {
    }
    ExecuteOptions retry = options(1);
    retry.folder.retry_failed = true;
    ASSERT_TRUE(dies(retry));
    const ExecuteOutcome outcome = execute(study, folder, nullptr, options(1));
    EXPECT_TRUE(outcome.archive_is_complete);
    EXPECT_EQ(archive::StudyFile(folder.archive()).status(deadly_point), PointStatus::Failed);
    EXPECT_FALSE(is_there(folder.journals()));
}

} // namespace
} // namespace culm::study
