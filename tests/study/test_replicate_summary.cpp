// SPDX-License-Identifier: BSD-3-Clause
// The spread of a study's stems from given b1 and b2: components, indices, dependent factors.
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

TEST(ReplicateSummary, IndicesOfKnownLawsAreTheirClosedForms) {
    const Study study =
        study_of(population + "[design]\ntype = \"sobol\"\npoints = 256\nscrambling = \"owen\"\n");
    // b1 = −β/261 has one factor. ln Y has the variance ln(1 + 1/4), a uniform of 12 mm 12 mm².
    const auto b1 = values_of(study, [](auto row) { return -row[1] / 261.0; });
    const auto b2 =
        values_of(study, [](auto row) { return 10.0 * std::log(row[0]) + 1000.0 * row[2]; });
    const auto summary = summarise_replicates(study, b1, b2);
    ASSERT_TRUE(summary && summary->responses[0].sensitivity);
    EXPECT_TRUE(summary->has_distributions);
    const auto& of_decay = *summary->responses[0].sensitivity;
    // The errors are rounding and the truncation at four standard deviations.
    EXPECT_NEAR(of_decay.groups[1].first_order.value, 1.0, 1e-9);
    EXPECT_NEAR(of_decay.standard_deviation, 30.0 / 261.0, 1e-3 * 30.0 / 261.0);
    const auto& of_frequency = *summary->responses[1].sensitivity;
    const double of_modulus = 100.0 * std::log1p(0.25);
    const double of_length = 12.0;
    EXPECT_NEAR(of_frequency.groups[0].total.value, of_modulus / (of_modulus + of_length), 1e-6);
    EXPECT_NEAR(of_frequency.groups[2].first_order.value, of_length / (of_modulus + of_length),
                1e-6);
    EXPECT_EQ(of_frequency.degree, 1) << "lognormal factors enter by their logarithms";
}

TEST(ReplicateSummary, DependentFactorsAreOneGroup) {
    const Study correlated = study_of(
        population + "[design]\ntype = \"latin_hypercube\"\npoints = 200\n[correlation]\n"
                     "factors = [\"bond_damping\", \"length_mm\"]\nrank = [[1, 0.5], [0.5, 1]]\n");
    const auto b2 = values_of(correlated, [](auto row) { return row[1] + 5000.0 * row[2]; });
    const auto summary = summarise_replicates(correlated, b2, b2);
    ASSERT_TRUE(summary && summary->responses[1].sensitivity);
    ASSERT_EQ(summary->groups.size(), 2U);
    EXPECT_EQ(summary->groups[1].name, "bond_damping, length_mm");
    EXPECT_NEAR(summary->responses[1].sensitivity->groups[1].first_order.value, 1.0, 1e-9);
    const Study rows = study_of("[factors]\n"
                                "length_mm = { distribution = \"empirical\", file = \"stems.csv\", "
                                "column = \"length_mm\", rows = \"together\" }\n"
                                "bond_diameter_mm = { distribution = \"empirical\", file = "
                                "\"stems.csv\", column = \"d\", rows = \"together\" }\n"
                                "bond_damping = { distribution = \"uniform\", min = 1, max = 2 }\n"
                                "[replicates]\nstems = 60\n");
    const auto y = values_of(rows, [](auto row) { return 1e5 * row[0] * row[1] + row[2]; });
    const auto found = summarise_replicates(rows, y, y);
    ASSERT_TRUE(found && found->responses[0].sensitivity);
    EXPECT_EQ(found->groups.size(), 2U);
    // Three functions describe any law of four rows.
    EXPECT_GT(found->responses[0].sensitivity->predicted_share, 1.0 - 1e-9);
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

TEST(ReplicateSummary, GivesReasonsWithoutADistributionOrEnoughPoints) {
    EXPECT_FALSE(
        summarise_replicates(study_of(""), std::vector<double>{1.0}, std::vector<double>{1.0}));
    const Study list = study_of("[design]\ntype = \"list\"\n[[design.point]]\nbond_damping = 1\n"
                                "[[design.point]]\nbond_damping = 2\n");
    const std::vector<double> y{1.0, 2.0};
    const auto summary = summarise_replicates(list, y, y);
    StudySummary all;
    all.replicates = summary;
    const nlohmann::json out = summary_json(all);
    EXPECT_EQ(out["sensitivity"]["reason"], "the points of a list have no distribution");
    EXPECT_EQ(out["population"]["frequency"]["mean"], 1.5);
    EXPECT_FALSE(out.contains("variance_components"));
    const Study few = study_of("[factors]\nbond_damping = [1, 2]\n");
    EXPECT_EQ(summarise_replicates(few, y, y)->no_sensitivity_reason,
              "2 points are too few for 1 inputs");
}

} // namespace
} // namespace culm::study
