// SPDX-License-Identifier: BSD-3-Clause
// Failed points are recorded with their reasons and do not affect the others.
#include "run/simulate.hpp"
#include "small_studies.hpp"
#include "study/execute/execute.hpp"
#include "study/summary/summary.hpp"
#include "support/temporary_folder.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace culm::study {
namespace {

using archive::PointStatus;

/// Runs a study in `where` and opens its archive.
ArchivedStudy executed(const Study& study, const StudyFolder& where) {
    EXPECT_TRUE(execute(study, where, nullptr, {}).archive_is_complete);
    return {archive::StudyFile(where.archive()), study};
}

/// An explicit study whose step lies just above the limit of one of its points.
Study study_with_an_unstable_point() {
    Study study = small::unchecked(small::explicit_study);
    const double limit =
        run::largest_stable_timestep(case_of_point(study.config, study.design, 10));
    const double next = run::largest_stable_timestep(case_of_point(study.config, study.design, 9));
    EXPECT_GT(next, 1.05 * limit);
    run::CaseSpec& base = study.config.base;
    base.integrator.timestep = 1.02 * limit;
    base.sample_interval = 100 * base.integrator.timestep;
    base.duration = 2000 * base.sample_interval; // the instability needs time to grow out of noise
    return study;
}

TEST(ExecuteFailures, UnstablePointIsRecordedAndItsNeighboursInTheLanesComplete) {
    const tests::TemporaryFolder folder;
    const Study study = study_with_an_unstable_point();
    const ArchivedStudy archived = executed(study, StudyFolder(folder / "s"));
    for (std::int64_t point = 0; point < 10; ++point) {
        EXPECT_EQ(archived.file.status(point), PointStatus::Completed) << "point " << point;
        EXPECT_TRUE(std::isfinite(archived.file.result("frequency")[std::size_t(point)]));
    }
    EXPECT_EQ(archived.file.status(10), PointStatus::Failed);
    EXPECT_EQ(archived.file.failure_kind(10), "instability");
    EXPECT_NE(archived.file.failure_reason(10).find("above the largest stable one"),
              std::string::npos)
        << archived.file.failure_reason(10);
}

TEST(ExecuteFailures, FailedPointIsListedInTheSummaryAndLeftOutOfTheRegressions) {
    const tests::TemporaryFolder folder;
    const Study study = study_with_an_unstable_point();
    const ArchivedStudy archived = executed(study, StudyFolder(folder / "s"));
    const StudySummary summary = reduce_study(archived, std::nullopt);
    EXPECT_EQ(summary.points, 11);
    EXPECT_EQ(summary.completed, 10);
    ASSERT_EQ(summary.failed.size(), 1U);
    EXPECT_EQ(summary.failed[0].point, 10);
    EXPECT_EQ(summary.failed[0].kind, "instability");
    EXPECT_EQ(summary.failed[0].reason, archived.file.failure_reason(10));
    EXPECT_TRUE(std::isnan(summary.frequency[10]));
    EXPECT_EQ(summary.regression.points_used, 10U);
    EXPECT_EQ(summary.regression.points_excluded, 1U);
}

TEST(ExecuteFailures, FailedPointIsNotComputedAgainByAResume) {
    const tests::TemporaryFolder folder;
    const Study study = study_with_an_unstable_point();
    const StudyFolder where(folder / "s");
    const ExecuteOutcome first = execute(study, where, nullptr, {});
    EXPECT_EQ(first.farm.points_completed, 10);
    EXPECT_EQ(first.farm.points_failed, 1);
    ExecuteOptions options;
    options.folder.resume = true;
    EXPECT_EQ(execute(study, where, nullptr, options).resumed_points, 11);
}

TEST(ExecuteFailures, StemWithoutAnEquilibriumIsRecordedAndTheOthersComplete) {
    const tests::TemporaryFolder folder;
    Study study = small::unchecked("[stem]\nspheres = 8\n[vibration]\nduration_s = 5e-3\n"
                                   "sample_interval_s = 2e-5\n"
                                   "[factors]\ntip_deflection_mm = [1, 2, 3]\n");
    study.design.values[1] = std::nan(""); // checks would refuse this deflection
    const ArchivedStudy archived = executed(study, StudyFolder(folder / "s"));
    EXPECT_EQ(archived.file.statuses(),
              (std::vector{PointStatus::Completed, PointStatus::Failed, PointStatus::Completed}));
    EXPECT_EQ(archived.file.failure_kind(1), "static_failed");
    EXPECT_EQ(archived.file.failure_reason(1).substr(0, 20), "no equilibrium found");
}

const std::string overdamped_study = R"(
[stem]
spheres = 8
[release]
tip_deflection_mm = 1
[vibration]
duration_s = 5e-3
sample_interval_s = 2e-5
[factors]
bond_damping = [4, 8, 1e5]
)";

TEST(ExecuteFailures, HistoryThatDoesNotSwingKeepsItsPointAndFailsInTheSummary) {
    const tests::TemporaryFolder folder;
    const Study study = small::unchecked(overdamped_study);
    const ArchivedStudy archived = executed(study, StudyFolder(folder / "s"));
    EXPECT_EQ(archived.file.status(2), PointStatus::Completed);
    EXPECT_EQ(archived.file.tip_deflection(2).size(), study.config.base.sample_count());
    EXPECT_TRUE(std::isnan(archived.file.result("frequency")[2]));
    const StudySummary summary = reduce_study(archived, std::nullopt);
    EXPECT_EQ(summary.completed, 2);
    ASSERT_EQ(summary.failed.size(), 1U);
    EXPECT_EQ(summary.failed[0].point, 2);
    EXPECT_EQ(summary.failed[0].kind, "fit_failed");
    EXPECT_FALSE(summary.failed[0].reason.empty());
}

TEST(ExecuteFailures, HistoryThatDoesNotSwingFailsItsPointWhenOnlyTheFitIsStored) {
    const tests::TemporaryFolder folder;
    const Study study = small::unchecked("[study]\nstore = \"fit\"\n" + overdamped_study);
    const ArchivedStudy archived = executed(study, StudyFolder(folder / "s"));
    EXPECT_EQ(archived.file.status(2), PointStatus::Failed);
    EXPECT_EQ(archived.file.failure_kind(2), "fit_failed");
    const StudySummary summary = reduce_study(archived, std::nullopt);
    ASSERT_EQ(summary.failed.size(), 1U);
    EXPECT_EQ(summary.failed[0].reason, archived.file.failure_reason(2));
}

} // namespace
} // namespace culm::study
