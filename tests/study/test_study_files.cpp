// SPDX-License-Identifier: BSD-3-Clause
// Files that a study names: their location, and how the archive keeps their texts.
#include "core/error.hpp"
#include "small_studies.hpp"
#include "study/config/study_config.hpp"
#include "study/execute/execute.hpp"
#include "study/execute/journal_notes.hpp"
#include "study/summary/summary.hpp"
#include "support/temporary_folder.hpp"

#include <fstream>

#include <gtest/gtest.h>

namespace culm::study {
namespace {

const std::string effect = "[effect]\nname = \"mine\"\nkind = \"force_per_length\"\n"
                           "expression = \"-c*v\"\n"
                           "[parameters.c]\ndefault = 1e-4\nlower = 0\nupper = 1\n";
const std::string study_text = "[study]\neffects = [\"law/mine.toml\"]\n"
                               "[stem]\nspheres = 8\n[vibration]\nduration_s = 0.01\n"
                               "[factors]\nbond_damping = [5, 10]\n";

TEST(StudyFiles, SurviveConversionToTextAndBack) {
    const StudyFiles files{{"a.csv", "x,y\n1,\"2\"\n"}, {"law/b.toml", "κ = 1 # \\ \t"}};
    EXPECT_EQ(files_from_text(to_text(files)), files);
    EXPECT_TRUE(files_from_text("").empty());
    EXPECT_TRUE(files_from_text(to_text({})).empty());
}

TEST(StudyFiles, AreRefusedInATextOfAnotherForm) {
    for (const char* text : {"[1]", "{\"a\": 1}", "{", "null x"})
        EXPECT_THROW((void)files_from_text(text), core::InputError) << text;
}

TEST(StudyFiles, MayContainBytesThatAreNotText) {
    EXPECT_NO_THROW((void)files_from_text(to_text({{"a", "\xFF\xFE"}})));
}

TEST(StudyFiles, AreReadFromTheFolderOfTheStudyAndKept) {
    const tests::TemporaryFolder folder;
    std::filesystem::create_directories(folder / "law");
    std::ofstream(folder / "law/mine.toml") << effect;
    std::ofstream(folder / "s.toml") << study_text;
    const StudyConfig config = load_config(folder / "s.toml");
    EXPECT_EQ(config.files, (StudyFiles{{"law/mine.toml", effect}}));
}

TEST(StudyFiles, AreNotReadFromTheDiskIfTheyAreSupplied) {
    const StudyConfig config =
        parse_config(study_text, "/nowhere/s.toml", {{"law/mine.toml", effect}, {"unused", ""}});
    EXPECT_EQ(config.files, (StudyFiles{{"law/mine.toml", effect}}));
    EXPECT_THROW((void)parse_config(study_text, "/nowhere/s.toml"), core::InputError);
}

TEST(StudyFiles, AreReadFromTheArchiveAlone) {
    const tests::TemporaryFolder place;
    const StudyFolder folder(place / "out");
    const Study study = parse_study(study_text, "/nowhere/s.toml", {{"law/mine.toml", effect}});
    ASSERT_TRUE(execute(study, folder, nullptr, {}).archive_is_complete);
    EXPECT_EQ(open_archive(folder).study.config.files, study.config.files);
    EXPECT_EQ(open_archive(folder).study.config.identity(), study.config.identity());
}

TEST(StudyFiles, AreKeptInTheNoteOfTheFolder) {
    const tests::TemporaryFolder place;
    const StudyFolder folder(place / "out");
    const archive::Texts note{{"points", "3"}, {"config", study_text}, {"start", "now"}};
    write_note(folder, note);
    EXPECT_EQ(read_note(folder), note);
}

TEST(StudyNote, IsRefusedWithAnImpossibleNumberOfPoints) {
    const tests::TemporaryFolder place;
    const StudyFolder folder(place / "out");
    for (const std::int64_t points : {std::int64_t{-1}, most_points + 1}) {
        write_note(folder, {{"points", std::to_string(points)}});
        EXPECT_THROW((void)read_note(folder), core::StorageError) << points;
    }
}

} // namespace
} // namespace culm::study
