// SPDX-License-Identifier: BSD-3-Clause
// The summary of a study has the documented keys and is JSON for all points.
#include "core/error.hpp"
#include "present/study/study.hpp"
#include "small_studies.hpp"
#include "study/execute/execute.hpp"
#include "study/summary/summary.hpp"
#include "support/file_content.hpp"
#include "support/temporary_folder.hpp"

#include <cmath>
#include <limits>
#include <set>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace culm::study {
namespace {

using present::summary_json;
using present::write_summary;

using nlohmann::json;

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// A factorial of smooth synthetic responses; the test chooses the levels.
StudySummary summary_of(const std::vector<double>& moduli, const std::vector<double>& dampings) {
    StudySummary summary;
    summary.ranks = 3;
    summary.wall_s = 1.5;
    for (const double damping : dampings) {
        for (const double modulus : moduli) {
            const double root = std::sqrt(modulus);
            summary.youngs_modulus.push_back(modulus);
            summary.bond_damping.push_back(damping);
            summary.decay_per_cycle.push_back(-damping / 260.0 - 1e-7 * root);
            summary.frequency.push_back(root / 570.0 - 0.01 * damping);
        }
    }
    summary.points = static_cast<std::int64_t>(summary.frequency.size());
    summary.completed = summary.points;
    summary.regression = reduce::regress_study(
        {summary.youngs_modulus, summary.bond_damping, summary.decay_per_cycle, summary.frequency},
        summary.reduce.significance);
    return summary;
}

std::set<std::string> keys_of(const json& object) {
    std::set<std::string> keys;
    for (const auto& [key, value] : object.items())
        keys.insert(key);
    return keys;
}

const std::vector<double> three_moduli{1e9, 4e9, 9e9};
const std::vector<double> three_dampings{50, 100, 150};

TEST(Summary, HasTheDocumentedKeys) {
    const json summary = summary_json(summary_of(three_moduli, three_dampings));
    EXPECT_EQ(keys_of(summary),
              (std::set<std::string>{"points", "stem", "completed", "failed", "ranks", "wall_s",
                                     "integrator", "fit", "regression", "is_published_stem"}));
    EXPECT_EQ(summary["points"], 9);
    EXPECT_EQ(summary["completed"], 9);
    EXPECT_EQ(summary["failed"], json::array());
    EXPECT_EQ(summary["ranks"], 3);
    EXPECT_EQ(summary["wall_s"], 1.5);
    EXPECT_EQ(summary["fit"],
              (json{{"window_s", nullptr}, {"amplitude", "free"}, {"significance", 0.05}}));
    EXPECT_EQ(keys_of(summary["regression"]),
              (std::set<std::string>{"sqrt_youngs_modulus", "bond_damping"}));
}

TEST(Summary, StatesHowTheHistoriesWereFitted) {
    StudySummary summary = summary_of(three_moduli, three_dampings);
    summary.reduce.window = 0.05;
    summary.reduce.is_amplitude_free = false;
    summary.reduce.significance = 0.01;
    EXPECT_EQ(summary_json(summary)["fit"],
              (json{{"window_s", 0.05}, {"amplitude", "fixed"}, {"significance", 0.01}}));
}

TEST(Summary, RegressionHasTheDocumentedKeysAndTheNumbersOfTheRegression) {
    const StudySummary summary = summary_of(three_moduli, three_dampings);
    const json all = summary_json(summary);
    const json& found = all["regression"]["sqrt_youngs_modulus"];
    EXPECT_EQ(keys_of(found), (std::set<std::string>{
                                  "predictor", "unit", "points", "intercept", "slope", "interval",
                                  "adjusted_r2", "largest_residual_percent", "terms",
                                  "terms_adjusted_r2", "adjusted_r2_full", "single_against_full"}));
    EXPECT_EQ(found["predictor"], "frequency");
    EXPECT_EQ(found["unit"], "sqrt(Pa)");
    EXPECT_EQ(found["points"], 9);
    const auto& single = summary.regression.sqrt_youngs_modulus.regression->single;
    EXPECT_EQ(found["slope"], single.slope.value);
    EXPECT_EQ(found["intercept"], single.intercept.value);
    EXPECT_EQ(found["interval"]["slope"], (json{single.slope.lower, single.slope.upper}));
    EXPECT_EQ(found["interval"]["intercept"],
              (json{single.intercept.lower, single.intercept.upper}));
    EXPECT_EQ(found["adjusted_r2"], single.regression.adjusted_r_squared);
    ASSERT_FALSE(found["terms"].empty());
    for (const json& term : found["terms"])
        EXPECT_EQ(keys_of(term), (std::set<std::string>{"term", "coefficient", "standard_error",
                                                        "interval", "p_value"}));
    EXPECT_EQ(all["regression"]["bond_damping"]["predictor"], "decay_per_cycle");
    EXPECT_EQ(all["regression"]["bond_damping"]["unit"], "1");
}

TEST(Summary, DesignWithOneDampingHasAReasonInsteadOfItsLaw) {
    const json all = summary_json(summary_of(three_moduli, {100}));
    const json& damping = all["regression"]["bond_damping"];
    EXPECT_EQ(keys_of(damping), (std::set<std::string>{"reason"}));
    EXPECT_EQ(damping["reason"], "bond_damping has the one value 100 at every point of the study: "
                                 "no law for it is identifiable");
    EXPECT_TRUE(all["regression"]["sqrt_youngs_modulus"]["slope"].is_number());
}

TEST(Summary, ResponseWithoutTermsSaysWhy) {
    // Three points determine a line with one degree of freedom, but not an interaction model.
    const json all = summary_json(summary_of(three_moduli, {100}));
    const json& found = all["regression"]["sqrt_youngs_modulus"];
    EXPECT_EQ(found["terms"], json::array());
    EXPECT_FALSE(found["terms_reason"].get<std::string>().empty());
}

TEST(Summary, StudyWithoutAnyFitHasReasonsForBoth) {
    StudySummary summary = summary_of(three_moduli, three_dampings);
    for (double& frequency : summary.frequency)
        frequency = not_a_number;
    summary.regression = reduce::regress_study(
        {summary.youngs_modulus, summary.bond_damping, summary.decay_per_cycle, summary.frequency},
        0.05);
    const json all = summary_json(summary);
    for (const char* response : {"sqrt_youngs_modulus", "bond_damping"})
        EXPECT_EQ(keys_of(all["regression"][response]), (std::set<std::string>{"reason"}));
}

TEST(Summary, IsJsonEvenWhenNumbersDoNotExist) {
    StudySummary summary = summary_of(three_moduli, three_dampings);
    summary.frequency[0] = not_a_number;
    auto& single = summary.regression.sqrt_youngs_modulus.regression->single;
    single.slope.upper = std::numeric_limits<double>::infinity();
    single.regression.adjusted_r_squared = not_a_number;
    const std::string text = summary_json(summary).dump(2);
    const json parsed = json::parse(text); // throws on a bare nan or inf
    EXPECT_TRUE(parsed["regression"]["sqrt_youngs_modulus"]["adjusted_r2"].is_null());
    EXPECT_TRUE(parsed["regression"]["sqrt_youngs_modulus"]["interval"]["slope"][1].is_null());
    EXPECT_EQ(text.find("nan"), std::string::npos);
    EXPECT_EQ(text.find("inf"), std::string::npos);
}

TEST(Summary, ListsFailedPoints) {
    StudySummary summary = summary_of(three_moduli, three_dampings);
    summary.failed.push_back({4, "instability", "the motion gained energy"});
    EXPECT_EQ(
        summary_json(summary)["failed"],
        (json::array(
            {{{"point", 4}, {"kind", "instability"}, {"reason", "the motion gained energy"}}})));
}

TEST(Summary, IsWrittenWithALineOfFitsForEveryPoint) {
    const tests::TemporaryFolder folder;
    StudySummary summary = summary_of({1e9}, {50, 100});
    summary.decay_per_cycle = {-0.25, not_a_number};
    summary.frequency = {55.5, not_a_number};
    write_summary(StudyFolder(folder.path()), summary);
    EXPECT_EQ(json::parse(tests::content_of(folder / "summary.json")), summary_json(summary));
    EXPECT_EQ(tests::content_of(folder / "fits.csv"),
              "point,bond_youngs_modulus_pa,bond_damping,decay_per_cycle,frequency_hz\n"
              "0,1000000000,50,-0.25,55.5\n"
              "1,1000000000,100,nan,nan\n");
}

TEST(Summary, RaisesAStorageErrorIfItCannotBeWritten) {
    const tests::TemporaryFolder folder;
    std::filesystem::create_directory(folder / "summary.json");
    try {
        write_summary(StudyFolder(folder.path()), summary_of(three_moduli, three_dampings));
        FAIL() << "no error";
    } catch (const core::StorageError& error) {
        EXPECT_EQ(error.what(), (folder / "summary.json").string() + ": cannot be written");
    }
}

class ArchiveSummary : public ::testing::Test {
  protected:
    void run(const std::string& text) {
        ExecuteOptions options;
        const Study study = parse_study(text, "s.toml");
        ASSERT_TRUE(execute(study, folder, nullptr, options).archive_is_complete);
    }
    tests::TemporaryFolder above;
    StudyFolder folder{above / "study"};
};

TEST_F(ArchiveSummary, EqualsThatOfFittingAgainUnderTheSameOptions) {
    run(small::implicit_study);
    const ArchivedStudy archived = open_archive(folder);
    const StudySummary stored = reduce_study(archived, std::nullopt);
    const StudySummary again = reduce_study(archived, archived.study.config.reduce);
    EXPECT_EQ(summary_json(again), summary_json(stored));
    EXPECT_EQ(stored.completed, 12);
    EXPECT_EQ(stored.ranks, 1);
    EXPECT_EQ(stored.youngs_modulus[3], 9e9);
    EXPECT_EQ(stored.bond_damping[4], 8.0);
}

TEST_F(ArchiveSummary, DiffersForAShorterWindow) {
    run(small::implicit_study);
    const ArchivedStudy archived = open_archive(folder);
    ReduceOptions shorter = archived.study.config.reduce;
    shorter.window = 2.5e-3;
    const StudySummary found = reduce_study(archived, shorter);
    EXPECT_EQ(found.completed, 12);
    EXPECT_NE(found.frequency, reduce_study(archived, std::nullopt).frequency);
    EXPECT_EQ(found.reduce.window, 2.5e-3);
}

TEST_F(ArchiveSummary, CannotBeFittedAgainIfTheStudyStoresFitsOnly) {
    std::string text = small::explicit_study;
    text.replace(text.find("\"tip\""), 5, "\"fit\"");
    run(text);
    const ArchivedStudy archived = open_archive(folder);
    EXPECT_EQ(reduce_study(archived, std::nullopt).completed, 11);
    EXPECT_EQ(reduce_study(archived, std::nullopt).reduce.significance, 0.05);
    EXPECT_EQ(reduce_study(archived, std::nullopt, 0.2).reduce.significance, 0.2)
        << "the F-tests need no histories";
    try {
        (void)reduce_study(archived, archived.study.config.reduce);
        FAIL() << "accepted";
    } catch (const core::InputError& error) {
        EXPECT_EQ(error.what(), folder.archive().string() +
                                    ": the study stores no tip histories (study.store = \"fit\"), "
                                    "so they cannot be fitted again");
    }
}

std::string refusal_to_open(const StudyFolder& folder) {
    try {
        (void)open_archive(folder);
    } catch (const core::InputError& error) {
        return error.what();
    }
    return "accepted";
}

TEST(OpenArchive, ReportsAMissingStudy) {
    EXPECT_EQ(refusal_to_open(StudyFolder("no/such/folder")),
              "no/such/folder: there is no study here (study.h5 is missing)");
}

TEST(OpenArchive, ExplainsHowToFinishAnIncompleteStudy) {
    const tests::TemporaryFolder folder;
    std::filesystem::create_directory(folder / "journal");
    const std::string place = folder.path().string();
    EXPECT_EQ(refusal_to_open(StudyFolder(folder.path())),
              place + ": the study is not complete; run `culm run STUDY.toml -o " + place +
                  " --resume` first");
}

} // namespace
} // namespace culm::study
