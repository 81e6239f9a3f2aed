// SPDX-License-Identifier: BSD-3-Clause
// The results of a study depend neither on the ranks nor on interruptions.
#include "archive/journal/read.hpp"
#include "archive/journal/writer.hpp"
#include "core/error.hpp"
#include "small_studies.hpp"
#include "study/execute/execute.hpp"
#include "support/temporary_folder.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include <gtest/gtest.h>

namespace culm::study {
namespace {

class Execute : public ::testing::Test {
  protected:
    [[nodiscard]] bool is_root() const { return world_.rank() == 0; }
    [[nodiscard]] StudyFolder folder(const std::string& name) const {
        return StudyFolder(place_ / name);
    }

    /// Collective; runs to the end.
    [[nodiscard]] ExecuteOutcome execute_together(const Study& study, const std::string& name,
                                                  bool resume = false) const {
        ExecuteOptions options;
        options.folder.resume = resume;
        return execute(study, folder(name), &world_, options);
    }

    /// On rank 0: the expected data, from a run without MPI and without interruptions.
    [[nodiscard]] small::StudyData data_of_undisturbed_run(const Study& study) const {
        EXPECT_TRUE(execute(study, folder("alone"), nullptr, {}).archive_is_complete);
        return data_in("alone");
    }
    [[nodiscard]] small::StudyData data_in(const std::string& name) const {
        return small::data_of(archive::StudyFile(folder(name).archive()));
    }

    /// On rank 0: compares each part separately, so that a failure shows which part differs.
    void expect_data_of_undisturbed_run(const std::string& name, const Study& study) const {
        const small::StudyData expected = data_of_undisturbed_run(study);
        const small::StudyData found = data_in(name);
        EXPECT_EQ(found.statuses, expected.statuses);
        EXPECT_TRUE(found.design == expected.design);
        EXPECT_TRUE(found.results == expected.results);
        EXPECT_TRUE(found.histories == expected.histories);
        EXPECT_EQ(found.failures, expected.failures);
        // Histories of NaN and empty histories would also be equal.
        const archive::StudyFile file(folder(name).archive());
        for (const double frequency : file.result("frequency"))
            EXPECT_TRUE(std::isfinite(frequency));
        const std::vector<double> tip = file.tip_deflection(0);
        EXPECT_EQ(tip.size(), study.config.base.sample_count());
        EXPECT_LT(*std::min_element(tip.begin(), tip.end()), -0.1 * tip.front());
    }

    /// Points in the journals of a folder.
    [[nodiscard]] static std::int64_t journalled_points(const StudyFolder& where,
                                                        const std::string& identity) {
        std::int64_t points = 0;
        for (const auto& scan : archive::scan_journal_folder(where.journals(), identity))
            points += static_cast<std::int64_t>(scan.entries.size());
        return points;
    }

    /// Stops as soon as the journals contain `count` points; checked after every point.
    [[nodiscard]] static ExecuteOptions stopping_after(std::int64_t count, const Study& study,
                                                       const StudyFolder& where) {
        ExecuteOptions options;
        options.farm.chunk_seconds = 0.0; // one batch at a time
        options.farm.stop_interval = std::chrono::milliseconds(0);
        options.farm.stop_requested = [=, identity = study.config.identity()] {
            return journalled_points(where, identity) >= count;
        };
        return options;
    }

    farm::Communicator world_ = farm::Communicator::world();

  private:
    std::unique_ptr<tests::TemporaryFolder> owner_ =
        world_.rank() == 0 ? std::make_unique<tests::TemporaryFolder>() : nullptr;
    std::filesystem::path place_ = world_.broadcast(owner_ ? owner_->path().string() : "");
};

TEST_F(Execute, ImplicitStudyHasTheSameBitsForAnyNumberOfRanks) {
    const Study study = parse_study(small::implicit_study, "s.toml");
    const ExecuteOutcome outcome = execute_together(study, "ranks");
    EXPECT_TRUE(outcome.archive_is_complete);
    EXPECT_EQ(outcome.resumed_points, 0);
    EXPECT_EQ(outcome.farm.points_completed, 12);
    EXPECT_EQ(outcome.farm.ranks, world_.size());
    if (is_root()) {
        expect_data_of_undisturbed_run("ranks", study);
        EXPECT_FALSE(std::filesystem::exists(folder("ranks").journals()));
    }
    world_.barrier();
}

TEST_F(Execute, ExplicitStudyWithAPartlyEmptyBatchHasTheSameBitsForAnyNumberOfRanks) {
    const Study study = parse_study(small::explicit_study, "s.toml");
    const ExecuteOutcome outcome = execute_together(study, "ranks");
    EXPECT_TRUE(outcome.archive_is_complete);
    EXPECT_EQ(outcome.farm.points_completed, 11);
    if (is_root())
        expect_data_of_undisturbed_run("ranks", study);
    world_.barrier();
}

TEST_F(Execute, TimestepStudyHasTheSameBitsForAnyNumberOfRanksAndAfterAnInterruption) {
    const Study study = parse_study(small::timestep_study, "s.toml");
    const ExecuteOutcome stopped =
        execute(study, folder("steps"), &world_, stopping_after(1, study, folder("steps")));
    const std::int64_t kept = stopped.farm.points_completed;
    EXPECT_GE(kept, 1);
    world_.barrier();
    const ExecuteOutcome finished = execute_together(study, "steps", true);
    EXPECT_TRUE(finished.archive_is_complete);
    EXPECT_EQ(finished.resumed_points, kept);
    if (is_root()) {
        EXPECT_TRUE(execute(study, folder("alone"), nullptr, {}).archive_is_complete);
        EXPECT_TRUE(data_in("steps") == data_in("alone"));
        for (const double limit :
             archive::StudyFile(folder("steps").archive()).result("limit_stable"))
            EXPECT_GT(limit, 0.0);
    }
    world_.barrier();
}

TEST_F(Execute, InterruptedStudyIsFinishedByComputingOnlyWhatIsMissing) {
    // There are more batches than ranks for any number of lanes.
    std::string text = small::implicit_study;
    const std::string levels = "[1, 2, 4, 9]";
    text.replace(text.find(levels), levels.size(),
                 "[1, 1.5, 2, 2.5, 3, 3.5, 4, 4.5, 5, 5.5, 6, 6.5, 7, 7.5, 8, 8.5, 9, 9.5]");
    const Study study = parse_study(text, "s.toml");
    const std::int64_t points = study.design.point_count();
    const ExecuteOutcome stopped =
        execute(study, folder("stopped"), &world_, stopping_after(3, study, folder("stopped")));
    EXPECT_FALSE(stopped.archive_is_complete);
    EXPECT_TRUE(stopped.farm.stopped_early);
    EXPECT_FALSE(std::filesystem::exists(folder("stopped").archive()));
    const std::int64_t kept = stopped.farm.points_completed;
    EXPECT_GE(kept, 3);
    EXPECT_LT(kept, points);
    EXPECT_EQ(journalled_points(folder("stopped"), study.config.identity()), kept);
    world_.barrier();

    const ExecuteOutcome finished = execute_together(study, "stopped", true);
    EXPECT_TRUE(finished.archive_is_complete);
    EXPECT_EQ(finished.resumed_points, kept);
    EXPECT_EQ(finished.farm.points_total, points - kept);
    EXPECT_EQ(finished.farm.points_completed, points - kept);
    if (is_root())
        expect_data_of_undisturbed_run("stopped", study);
    world_.barrier();
}

TEST_F(Execute, ExplicitStudyBegunAloneIsFinishedByAnyNumberOfRanks) {
    const Study study = parse_study(small::explicit_study, "s.toml");
    std::string kept = "0";
    if (is_root()) {
        const ExecuteOutcome stopped =
            execute(study, folder("begun"), nullptr, stopping_after(1, study, folder("begun")));
        EXPECT_FALSE(stopped.archive_is_complete);
        kept = std::to_string(stopped.farm.points_completed);
    }
    const std::int64_t before = std::stoll(world_.broadcast(kept));
    EXPECT_GE(before, 1);
    EXPECT_LT(before, 11);
    const ExecuteOutcome finished = execute_together(study, "begun", true);
    EXPECT_TRUE(finished.archive_is_complete);
    EXPECT_EQ(finished.resumed_points, before);
    EXPECT_EQ(finished.farm.points_completed, 11 - before);
    if (is_root())
        expect_data_of_undisturbed_run("begun", study);
    world_.barrier();
}

TEST_F(Execute, CompleteStudyIsNotComputedAgain) {
    const Study study = parse_study(small::explicit_study, "s.toml");
    EXPECT_TRUE(execute_together(study, "ranks").archive_is_complete);
    const ExecuteOutcome again = execute_together(study, "ranks", true);
    EXPECT_TRUE(again.archive_is_complete);
    EXPECT_EQ(again.resumed_points, 11);
    EXPECT_EQ(again.farm.points_total, 0);
    world_.barrier();
}

TEST_F(Execute, FolderThatIsTakenIsRefusedOnEveryRank) {
    EXPECT_TRUE(execute_together(parse_study(small::explicit_study, "s.toml"), "ranks")
                    .archive_is_complete);
    EXPECT_THROW((void)execute_together(parse_study(small::explicit_study, "s.toml"), "ranks"),
                 core::InputError);
    EXPECT_THROW(
        (void)execute_together(parse_study(small::implicit_study, "s.toml"), "ranks", true),
        core::InputError);
    world_.barrier();
}

TEST_F(Execute, JournalThatOneRankCannotWriteIsAnErrorOnEveryRank) {
    const Study study = parse_study(small::explicit_study, "s.toml");
    std::optional<archive::JournalWriter> other_run; // holds the lock of the last rank's journal
    if (is_root())
        other_run.emplace(folder("busy").journal_of_rank(world_.size() - 1),
                          study.config.identity());
    world_.barrier();
    try {
        (void)execute_together(study, "busy", true);
        ADD_FAILURE() << "not refused";
    } catch (const core::StorageError& error) {
        const std::string text = error.what();
        const std::string expected = world_.rank() == world_.size() - 1
                                         ? "is the study running already?"
                                         : "another rank cannot write its journal";
        EXPECT_NE(text.find(expected), std::string::npos) << text;
    }
    world_.barrier();
}

} // namespace
} // namespace culm::study
