// SPDX-License-Identifier: BSD-3-Clause
// The spread of a study's stems from given b1 and b2: components, shares, dependent factors.
#include "present/study/study.hpp"
#include "study/summary/summary.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace culm::study {
namespace {

using present::summary_json;

Study study_of(const std::string& text) {
    const StudyFiles files{{"stems.csv", "length_mm,d\n150,2.5\n152,2.7\n157,2.6\n160,2.9\n"}};
    Study study{parse_config(text, "s.toml", files), {}};
    study.design = make_design(study.config);
    return study;
}

/// Evaluates a formula of the factors, in SI, at every point.
template <class Formula>
std::vector<double> values_of(const Study& study, Formula formula) {
    std::vector<double> values;
    for (std::int64_t point = 0; point < study.design.point_count(); ++point)
        values.push_back(formula(study.design.row(point)));
    return values;
}

const std::string population =
    "[factors]\n"
    "bond_youngs_modulus_gpa = { distribution = \"lognormal\", mean = 2, sd = 1 }\n"
    "bond_damping = { distribution = \"normal\", mean = 120, sd = 30, min = 0, max = 240 }\n"
    "length_mm = { distribution = \"uniform\", min = 150, max = 162 }\n";

TEST(ReplicateSummary, SharesOfKnownLawsAreTheirClosedForms) {
    const Study study =
        study_of(population + "[design]\ntype = \"sobol\"\npoints = 256\nscrambling = \"owen\"\n");
    // b1 = −β/261 has one factor. ln Y has the variance ln(1 + 1/4), a uniform of 12 mm 12 mm².
    const auto b1 = values_of(study, [](auto row) { return -row[1] / 261.0; });
    const auto b2 =
        values_of(study, [](auto row) { return 10.0 * std::log(row[0]) + 1000.0 * row[2]; });
    const auto summary = summarise_replicates(study, b1, b2);
    ASSERT_TRUE(summary && summary->responses[0].variance_shares);
    EXPECT_TRUE(summary->has_distributions);
    const auto& of_decay = summary->responses[0].variance_shares->shares;
    ASSERT_EQ(of_decay.size(), 4U);
    EXPECT_NEAR(of_decay[1].value, 1.0, 0.01);
    const auto& of_frequency = summary->responses[1].variance_shares->shares;
    const double of_modulus = 100.0 * std::log1p(0.25);
    const double of_length = 12.0;
    // The variances of a sample of 256 points, confined to four standard deviations.
    EXPECT_NEAR(of_frequency[0].value, of_modulus / (of_modulus + of_length), 0.02);
    EXPECT_NEAR(of_frequency[2].value, of_length / (of_modulus + of_length), 0.02);
    EXPECT_NEAR(of_frequency[3].value, 0.0, 1e-9) << "lognormal factors enter by their logarithms";
}

TEST(ReplicateSummary, DependentFactorsAreOneGroup) {
    const Study rows = study_of("[factors]\n"
                                "length_mm = { distribution = \"empirical\", file = \"stems.csv\", "
                                "column = \"length_mm\", rows = \"together\" }\n"
                                "bond_diameter_mm = { distribution = \"empirical\", file = "
                                "\"stems.csv\", column = \"d\", rows = \"together\" }\n"
                                "bond_damping = { distribution = \"uniform\", min = 1, max = 2 }\n"
                                "[replicates]\nstems = 60\n");
    const auto y = values_of(rows, [](auto row) { return 1e5 * row[0] * row[1] + row[2]; });
    const auto found = summarise_replicates(rows, y, y);
    ASSERT_TRUE(found && found->responses[0].variance_shares);
    EXPECT_EQ(found->groups.size(), 2U);
    EXPECT_EQ(found->groups[0].name, "length_mm, bond_diameter_mm");
    // The constant, three columns for four rows of the table, and two of the damping.
    EXPECT_EQ(found->responses[0].variance_shares->columns, 6);
    EXPECT_NEAR(found->responses[0].variance_shares->shares.back().value, 0.0, 1e-9);
}

TEST(ReplicateSummary, TestsOfStemsGiveVarianceComponents) {
    const Study study =
        study_of(population + "tip_deflection_mm = { distribution = \"uniform\", min = 10, max = "
                              "20, level = \"test\" }\n[replicates]\nstems = 200\nwithin = 5\n");
    const auto b1 = values_of(study, [](auto row) { return row[1] + 1000.0 * row[3]; });
    auto with_a_gap = b1;
    with_a_gap[7] = std::numeric_limits<double>::quiet_NaN();
    const auto summary = summarise_replicates(study, with_a_gap, b1);
    ASSERT_TRUE(summary && summary->responses[0].components);
    const auto& c = *summary->responses[1].components;
    EXPECT_EQ(c.stems, 200U);
    EXPECT_EQ(c.tests, 1000U);
    EXPECT_EQ(summary->responses[0].components->tests, 999U);
    // The variances are 900 and 100/12, with standard errors of 10 % and 5 %, times four.
    EXPECT_NEAR(c.between.variance, 900.0, 360.0);
    EXPECT_NEAR(c.within.variance, 100.0 / 12.0, 1.7);
    EXPECT_LT(c.between.interval.lower, 900.0);
    EXPECT_GT(c.between.interval.upper, 900.0);
}

TEST(ReplicateSummary, GivesReasonsWithoutEnoughPoints) {
    EXPECT_FALSE(
        summarise_replicates(study_of(""), std::vector<double>{1.0}, std::vector<double>{1.0}));
    const Study list = study_of("[design]\ntype = \"list\"\n[[design.point]]\nbond_damping = 1\n"
                                "[[design.point]]\nbond_damping = 2\n");
    const std::vector<double> y{1.0, 2.0};
    const auto summary = summarise_replicates(list, y, y);
    StudySummary all;
    all.replicates = summary;
    const nlohmann::json out = summary_json(all);
    EXPECT_EQ(out["variance_shares"]["reason"], "2 points are too few for 2 columns");
    EXPECT_EQ(out["population"]["frequency"]["mean"], 1.5);
    EXPECT_FALSE(out.contains("variance_components"));
    const Study grid = study_of("[factors]\nbond_damping = [1, 2, 3, 4, 5, 6]\n");
    all.replicates = summarise_replicates(grid, std::vector<double>(6, 1.0),
                                          std::vector<double>{1.0, 4.0, 9.0, 16.0, 25.0, 36.0});
    const nlohmann::json shares = summary_json(all)["variance_shares"];
    EXPECT_TRUE(shares["decay_per_cycle"]["rest"]["value"].is_null()) << "nothing varies";
    EXPECT_EQ(shares["frequency"]["points"], 6);
    EXPECT_EQ(shares["frequency"]["shares"][0]["group"], "bond_damping");
    EXPECT_NEAR(shares["frequency"]["shares"][0]["share"].get<double>(), 1.0, 1e-9);
}

} // namespace
} // namespace culm::study
