// SPDX-License-Identifier: BSD-3-Clause
// Folders that a study may use, and their contents.
#include "archive/journal/writer.hpp"
#include "archive/study/file.hpp"
#include "core/error.hpp"
#include "small_studies.hpp"
#include "study/execute/execute.hpp"
#include "study/execute/study_folder.hpp"
#include "support/temporary_folder.hpp"

#include <fstream>
#include <iostream>

#include <gtest/gtest.h>
#include <unistd.h>

namespace culm::study {
namespace {

namespace fs = std::filesystem;

const std::string identity = "factors.bond_damping = [1, 2]\nstem.spheres = 8\n";

class Folder : public ::testing::Test {
  protected:
    [[nodiscard]] FolderContent prepare(const std::string& now, bool resume) const {
        return prepare_folder(folder, now, 3, {resume, false, 2});
    }
    [[nodiscard]] std::string refusal(const std::string& now, bool resume) const {
        try {
            (void)prepare(now, resume);
        } catch (const core::InputError& error) {
            return error.what();
        }
        return "accepted";
    }
    /// Commits points to the journal of one rank.
    void commit(int rank, const std::vector<std::int64_t>& points) const {
        archive::JournalWriter journal(folder.journal_of_rank(rank), identity);
        for (const std::int64_t point : points) {
            archive::PointRecord record;
            record.point = point;
            record.completed = point != 2; // point 2 has failed
            journal.append(record);
        }
    }

    tests::TemporaryFolder above;
    StudyFolder folder{above / "study"};
};

TEST_F(Folder, IsCreatedWithEveryPointPendingIfMissing) {
    const FolderContent content = prepare(identity, false);
    EXPECT_EQ(content.pending_points, (std::vector<std::int64_t>{0, 1, 2}));
    EXPECT_FALSE(content.archive_is_complete);
    EXPECT_TRUE(fs::is_directory(folder.path()));
}

TEST_F(Folder, KnowsThePointsOfAllJournalsFailedOnesIncluded) {
    commit(0, {2});
    commit(3, {0});
    EXPECT_EQ(prepare(identity, true).pending_points, (std::vector<std::int64_t>{1}));
}

TEST_F(Folder, KeepsACompletedPointOfTheArchiveIfAJournalHasAFailureOfIt) {
    const Study study = parse_study(small::explicit_study, "s.toml");
    ASSERT_TRUE(execute(study, folder, nullptr, {}).archive_is_complete);
    {
        archive::JournalWriter journal(folder.journal_of_rank(1), study.config.identity());
        archive::PointRecord failed;
        failed.point = 4;
        failed.completed = false;
        failed.failure_reason = "a later attempt";
        journal.append(failed);
    }
    ExecuteOptions options;
    options.folder.resume = true;
    ASSERT_TRUE(execute(study, folder, nullptr, options).archive_is_complete);
    EXPECT_FALSE(fs::exists(folder.journals()));
    EXPECT_EQ(archive::StudyFile(folder.archive()).status(4), archive::PointStatus::Completed);
}

TEST_F(Folder, IsRefusedWithoutResumeIfItHasThisStudy) {
    commit(0, {1});
    EXPECT_EQ(refusal(identity, false),
              folder.path().string() +
                  " already holds this study, whole or in part; add --resume to compute only what "
                  "is missing, or choose another folder with -o");
}

TEST_F(Folder, IsRefusedWithTheDifferenceIfTheJournalIsOfAnotherStudy) {
    commit(0, {1});
    for (const bool resume : {false, true}) {
        const std::string text =
            refusal("factors.bond_damping = [1, 3]\nstem.spheres = 8\n", resume);
        EXPECT_EQ(text, folder.path().string() +
                            " already holds another study; choose another folder with -o. What "
                            "differs:\nfactors.bond_damping: stored [1, 2], now [1, 3]");
    }
}

TEST_F(Folder, IsRefusedWithTheDifferenceIfTheArchiveIsOfAnotherStudy) {
    const Study study = parse_study(small::explicit_study, "s.toml");
    ASSERT_TRUE(execute(study, folder, nullptr, {}).archive_is_complete);
    std::string other = small::explicit_study;
    other.replace(other.find("10, 11]"), 7, "10, 12]");
    const Study changed = parse_study(other, "s.toml");
    for (const bool resume : {false, true})
        EXPECT_EQ(refusal(changed.config.identity(), resume),
                  folder.path().string() +
                      " already holds another study; choose another folder with -o. What differs:"
                      "\nfactors.bond_damping: stored [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11], now "
                      "[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12]");
}

TEST_F(Folder, IsRefusedAndKeptUnchangedIfTheArchiveCannotBeRead) {
    fs::create_directories(folder.path());
    std::ofstream(folder.archive()) << "no HDF5";
    const std::string text = refusal(identity, true);
    EXPECT_EQ(text.find(folder.archive().string()), 0U) << text;
    EXPECT_NE(text.find("\nMove this file away to compute the study again, or choose another "
                        "folder with -o."),
              std::string::npos)
        << text;
    EXPECT_EQ(fs::file_size(folder.archive()), 7U);
}

TEST_F(Folder, IsRefusedIfItsPathIsAFile) {
    std::ofstream(folder.path()) << "a file";
    EXPECT_EQ(refusal(identity, false), "cannot create the folder " + folder.path().string() +
                                            ": Not a directory; choose another one with -o");
}

/// Prints the refusal of the folder and exits with code 2. The process runs as a user without
/// root's permissions, since root can write to every folder.
[[noreturn]] void end_with_refusal(const StudyFolder& folder) {
    constexpr uid_t nobody = 65534;
    if (::getuid() == 0 && ::setresuid(nobody, nobody, nobody) != 0)
        ::_exit(1);
    try {
        (void)prepare_folder(folder, identity, 3, {});
    } catch (const core::InputError& error) {
        std::cerr << error.what() << std::endl;
        ::_exit(2);
    } catch (const core::StorageError& error) {
        std::cerr << error.what() << std::endl;
        ::_exit(75);
    }
    ::_exit(0);
}

class FolderDeathTest : public Folder {
  protected:
    void SetUp() override {
        ::testing::FLAGS_gtest_death_test_style = "fast"; // the child continues with this fixture
        fs::permissions(above.path(), fs::perms(0755));   // others may search it
        fs::create_directory(folder.path());
    }
};

TEST_F(FolderDeathTest, IsRefusedIfReadOnly) {
    fs::permissions(folder.path(), fs::perms(0555));
    EXPECT_EXIT(end_with_refusal(folder), ::testing::ExitedWithCode(2),
                "cannot write to the folder .*/study: Permission denied; choose another one with "
                "-o");
}

TEST_F(FolderDeathTest, IsRefusedBelowAReadOnlyFolder) {
    fs::permissions(folder.path(), fs::perms(0555));
    EXPECT_EXIT(end_with_refusal(StudyFolder(folder.path() / "below")),
                ::testing::ExitedWithCode(2),
                "cannot create the folder .*/study/below: Permission denied; choose another one "
                "with -o");
}

TEST_F(FolderDeathTest, IsRefusedIfItCannotBeSearched) {
    fs::permissions(folder.path(), fs::perms(0600));
    EXPECT_EXIT(end_with_refusal(folder), ::testing::ExitedWithCode(2),
                "cannot look for .*/study/study.h5: Permission denied");
}

} // namespace
} // namespace culm::study
