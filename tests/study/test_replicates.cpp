// SPDX-License-Identifier: BSD-3-Clause
// Populations of stems: measured columns, nested tests, scrambled designs.
#include "refused.hpp"
#include "study/design/design.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <gtest/gtest.h>

namespace culm::study {
namespace {

const StudyFiles stems{{"stems.csv", "id,length_mm,d,wall_mm\n1,150,2.5,0.30\n2,155,2.6,0.35\n"
                                     "3,160,2.7,0.40\n"}};

StudyConfig config_with_stems(const std::string& text) {
    return parse_config(text, "s.toml", stems);
}

std::string refusal_with_stems(const std::string& text) {
    try {
        (void)config_with_stems(text);
    } catch (const core::InputError& error) {
        return error.what();
    }
    return "accepted";
}

std::string measured(const std::string& key, const std::string& column, const std::string& more) {
    return key + " = { distribution = \"empirical\", file = \"stems.csv\", column = \"" + column +
           "\"" + more + " }\n";
}

const std::string two = "bond_diameter_mm = { distribution = \"normal\", mean = 2.6, sd = 0.2 }\n"
                        "bond_wall_mm = { distribution = \"lognormal\", mean = 0.3, sd = 0.1, "
                        "max = 1 }\n";

TEST(EmpiricalFactor, RowsStayTogetherIfAsked) {
    for (const std::string design :
         {"[replicates]\nstems = 40\n", "[design]\ntype = \"latin_hypercube\"\npoints = 40\n",
          "[design]\ntype = \"sobol\"\npoints = 40\nscrambling = \"owen\"\n"}) {
        const std::string together = ", rows = \"together\"";
        const Design rows = make_design(
            config_with_stems("[factors]\n" + measured("length_mm", "length_mm", together) +
                              measured("bond_diameter_mm", "d", together) + design));
        const std::map<double, double> pairs{{0.150, 2.5e-3}, {0.155, 2.6e-3}, {0.160, 2.7e-3}};
        std::set<double> seen;
        for (std::int64_t point = 0; point < 40; ++point) {
            EXPECT_EQ(pairs.at(rows.row(point)[0]), rows.row(point)[1]);
            seen.insert(rows.row(point)[0]);
        }
        EXPECT_EQ(seen.size(), 3U);
        const Design mixed =
            make_design(config_with_stems("[factors]\n" + measured("length_mm", "length_mm", "") +
                                          measured("bond_diameter_mm", "d", "") + design));
        std::set<std::pair<double, double>> combinations;
        for (std::int64_t point = 0; point < 40; ++point)
            combinations.emplace(mixed.row(point)[0], mixed.row(point)[1]);
        EXPECT_GT(combinations.size(), 5U);
    }
}

TEST(EmpiricalFactor, RowsReplaceTheFormerTableOfCorrelations) {
    EXPECT_EQ(refusal("[factors]\n" + two + "[correlation]\nrank = [[1, 0.7], [0.7, 1]]\n"),
              "s.toml:4: correlation: unknown table (did you mean factors?)");
}

TEST(EmpiricalFactor, TheFileIsPartOfTheStudy) {
    const std::string text = "[factors]\n" + measured("bond_diameter_mm", "d", "");
    const StudyConfig config = config_with_stems(text);
    EXPECT_EQ(config.files, stems);
    StudyFiles other = stems;
    other["stems.csv"] = "d\n2.5\n2.6\n2.8\n";
    EXPECT_NE(parse_config(text, "s.toml", other).identity(), config.identity());
}

TEST(EmpiricalFactor, ReportsMistakes) {
    EXPECT_NE(refusal_with_stems("[factors]\nlength_mm = { distribution = \"empirical\" }\n")
                  .find("factors.length_mm.file is missing"),
              std::string::npos);
    EXPECT_NE(refusal_with_stems("[factors]\n" + measured("length_mm", "lenght_mm", ""))
                  .find("did you mean length_mm?"),
              std::string::npos);
    EXPECT_NE(refusal_with_stems("[factors]\n" + measured("length_mm", "length_mm", ", min = 1"))
                  .find("takes the values of its file as they are"),
              std::string::npos);
    EXPECT_NE(refusal("[factors]\nlength_mm = { distribution = \"empirical\", file = "
                      "\"../stems.csv\", column = \"d\" }\n"),
              "accepted");
    EXPECT_NE(refusal("[factors]\nlength_mm = { distribution = \"normal\", mean = 1, sd = 1, "
                      "colum = \"d\" }\n")
                  .find("did you mean column?"),
              std::string::npos);
}

const std::string nested =
    "[factors]\n"
    "bond_damping = { distribution = \"normal\", mean = 120, sd = 40, "
    "min = 10, max = 250, within_sd = 2 }\n"
    "bond_diameter_mm = { distribution = \"normal\", mean = 2.6, sd = 0.2 }\n"
    "tip_deflection_mm = { distribution = \"uniform\", min = 10, max = 20, "
    "level = \"test\" }\n";

TEST(NestedReplicates, StemsKeepTheirValuesAndTestsScatter) {
    for (const std::string design : {"", "[design]\ntype = \"latin_hypercube\"\npoints = 5\n",
                                     "[design]\ntype = \"sobol\"\npoints = 5\n"}) {
        const Design d = make_design(
            config_with_stems(nested + design + "[replicates]\nstems = 6\nwithin = 4\n"));
        ASSERT_EQ(d.tests, 4);
        ASSERT_EQ(d.replicates, 24);
        std::set<double> diameters;
        std::set<double> deflections;
        double squares = 0.0;
        for (std::int64_t stem = 0; stem < d.point_count() / 4; ++stem) {
            double mean = 0.0;
            for (std::int64_t test = 0; test < 4; ++test) {
                const auto row = d.row(4 * stem + test);
                EXPECT_EQ(row[1], d.row(4 * stem)[1]);
                diameters.insert(row[1]);
                deflections.insert(row[2]);
                mean += row[0] / 4.0;
            }
            for (std::int64_t test = 0; test < 4; ++test)
                squares += std::pow(d.row(4 * stem + test)[0] - mean, 2);
        }
        const auto stem_count = static_cast<std::size_t>(d.point_count() / 4);
        EXPECT_EQ(diameters.size(), stem_count);
        EXPECT_EQ(deflections.size(), 4 * stem_count);
        // With 18 degrees of freedom or more the standard deviation is known to 17 %, times three.
        EXPECT_NEAR(std::sqrt(squares / static_cast<double>(3 * stem_count)), 2.0, 1.0);
    }
}

TEST(NestedReplicates, OneTestIsTheStudyWithReplicates) {
    const std::string factor =
        "[factors]\nlength_mm = { distribution = \"normal\", mean = 156, sd = 4.5 }\n";
    const StudyConfig before = config_with_stems(factor + "[design]\nreplicates = 7\n");
    const StudyConfig now = config_with_stems(factor + "[replicates]\nstems = 7\n");
    EXPECT_EQ(before.identity(), now.identity());
    EXPECT_EQ(make_design(before).values, make_design(now).values);
}

TEST(NestedReplicates, ReportMistakes) {
    const std::string factor =
        "[factors]\nlength_mm = { distribution = \"normal\", mean = 156, sd = 4.5 }\n";
    EXPECT_NE(refusal(factor + "[replicates]\nwithin = 2\n")
                  .find("no factor has level = \"test\" or within_sd"),
              std::string::npos);
    EXPECT_NE(refusal(factor + "[design]\nreplicates = 2\n[replicates]\nstems = 2\n")
                  .find("not together with design.replicates"),
              std::string::npos);
    EXPECT_NE(refusal(factor + "[replicates]\nstem = 2\n").find("did you mean stems?"),
              std::string::npos);
    EXPECT_NE(refusal("[factors]\nlength_mm = { distribution = \"normal\", mean = 156, sd = 4.5, "
                      "level = \"test\", within_sd = 1 }\n")
                  .find("not with level = \"test\""),
              std::string::npos);
}

TEST(Scrambling, IsChosenByTheConfigAndPartOfTheIdentity) {
    const std::string hypercube =
        "[factors]\n" + two + "[design]\ntype = \"latin_hypercube\"\npoints = 50\n";
    const std::string sobol = "[factors]\n" + two + "[design]\ntype = \"sobol\"\npoints = 50\n";
    std::set<std::string> identities;
    std::set<std::vector<double>> designs;
    for (const std::string& text : {hypercube, sobol, sobol + "scrambling = \"owen\"\n"}) {
        const StudyConfig config = config_with_stems(text);
        identities.insert(config.identity());
        designs.insert(make_design(config).values);
        EXPECT_EQ(make_design(config).values, make_design(config).values);
    }
    EXPECT_EQ(identities.size(), 3U);
    EXPECT_EQ(designs.size(), 3U);
    EXPECT_NE(refusal(hypercube + "scrambling = \"owen\"\n").find("only with"), std::string::npos);
    EXPECT_NE(refusal(sobol + "scrambling = \"owens\"\n").find("did you mean \"owen\"?"),
              std::string::npos);
}

TEST(NestedReplicates, EverySettingIsPartOfTheIdentity) {
    const auto identity = [](const std::string& factor, const std::string& rest) {
        return config_with_stems("[factors]\n" + two +
                                 "bond_damping = { distribution = \"normal\", mean = 9, " +
                                 "sd = 1" + factor + " }\n" + rest)
            .identity();
    };
    const std::string tests = "[replicates]\nstems = 3\nwithin = 2\n";
    const std::set<std::string> identities{
        identity("", ""), identity(", level = \"test\"", tests),
        identity(", within_sd = 0.1", tests), identity(", within_sd = 0.2", tests),
        identity(", within_sd = 0.2", "[replicates]\nstems = 2\nwithin = 3\n")};
    EXPECT_EQ(identities.size(), 5U);
}

TEST(WallDensity, GivesTheMassOfTheSection) {
    const StudyConfig config =
        config_with_stems("[stem]\nlength_mm = 156\nbond_diameter_mm = 2.57\n"
                          "bond_wall_mm = 0.34\nwall_density_kg_m3 = 272\n");
    const auto& stem = config.base.stem;
    constexpr double pi = 3.14159265358979323846;
    const double sphere = stem.density * pi / 6.0 * std::pow(stem.sphere_diameter, 3);
    const double section = pi / 4.0 * (std::pow(2.57e-3, 2) - std::pow(1.89e-3, 2));
    // Rounding of some operations.
    EXPECT_NEAR(sphere / (272.0 * section * 0.156 / 55.0), 1.0, 1e-14);
    EXPECT_NE(refusal("[stem]\ndensity_kg_m3 = 1\nwall_density_kg_m3 = 1\n").find("not together"),
              std::string::npos);
}

} // namespace
} // namespace culm::study
