// SPDX-License-Identifier: BSD-3-Clause
// Designs of whole studies: order, replicates, reproducibility, size, and the check of every point.
#include "core/error.hpp"
#include "study/design/design.hpp"
#include "study/execute/plan.hpp"

#include <algorithm>
#include <set>

#include <gtest/gtest.h>

namespace culm::study {
namespace {

StudyConfig config_of(const std::string& text) {
    return parse_config(text, "s.toml");
}

Design design_of(const std::string& text) {
    return make_design(config_of(text));
}

const std::string drawn_length =
    "length_mm = { distribution = \"normal\", mean = 156, sd = 4.5, min = 140, max = 170 }\n";

TEST(Design, HasOnePointWithoutFactors) {
    const StudyConfig config = config_of("");
    const Design design = make_design(config);
    EXPECT_EQ(design.point_count(), 1);
    EXPECT_EQ(case_of_point(config, design, 0).stem.sphere_count, 56);
}

TEST(Design, FactorialVariesTheLastFactorFastest) {
    const Design design = design_of("[factors]\nbond_damping = [1, 2]\nspheres = [10, 20, 30]\n");
    EXPECT_EQ(design.values, (std::vector<double>{1, 10, 1, 20, 1, 30, 2, 10, 2, 20, 2, 30}));
}

TEST(Design, ReplicatesAreInnermostAndOnlyRedraw) {
    const Design design = design_of("[factors]\nbond_damping = [1, 2]\n" + drawn_length +
                                    "[design]\nreplicates = 3\n");
    ASSERT_EQ(design.point_count(), 6);
    std::set<double> lengths;
    for (std::int64_t point = 0; point < 6; ++point) {
        EXPECT_EQ(design.row(point)[0], point < 3 ? 1.0 : 2.0);
        lengths.insert(design.row(point)[1]);
    }
    EXPECT_EQ(lengths.size(), 6U) << "every draw differs";
}

TEST(Design, DrawsDoNotDependOnOtherFactorsOrTheirOrder) {
    const Design before = design_of("[factors]\nbond_damping = [1, 2]\n" + drawn_length);
    const Design after =
        design_of("[factors]\n" + drawn_length + "bond_damping = [1, 2]\nspheres = [20]\n");
    for (std::int64_t point = 0; point < 2; ++point)
        EXPECT_EQ(before.row(point)[1], after.row(point)[0]);
}

TEST(Design, MoreReplicatesKeepTheEarlierDraws) {
    const Design few = design_of("[factors]\n" + drawn_length + "[design]\nreplicates = 2\n");
    const Design many = design_of("[factors]\n" + drawn_length + "[design]\nreplicates = 9\n");
    EXPECT_EQ(few.row(0)[0], many.row(0)[0]);
    EXPECT_EQ(few.row(1)[0], many.row(1)[0]);
}

TEST(Design, TheSeedSelectsTheDraws) {
    EXPECT_EQ(design_of("[factors]\n" + drawn_length).values,
              design_of("[factors]\n" + drawn_length).values);
    EXPECT_NE(design_of("[factors]\n" + drawn_length).values,
              design_of("[study]\nseed = 2\n[factors]\n" + drawn_length).values);
}

TEST(Design, LatinHypercubeFillsTheStrataOfEveryFactor) {
    const Design design =
        design_of("[factors]\nbond_damping = { from = 0, to = 100 }\n"
                  "spheres = [10, 20, 30, 40]\n" +
                  drawn_length + "[design]\ntype = \"latin_hypercube\"\npoints = 100\n");
    std::set<int> strata;
    std::multiset<double> levels;
    for (std::int64_t point = 0; point < 100; ++point) {
        strata.insert(static_cast<int>(design.row(point)[0]));
        levels.insert(design.row(point)[1]);
    }
    EXPECT_EQ(strata.size(), 100U);
    for (const double level : {10.0, 20.0, 30.0, 40.0})
        EXPECT_EQ(levels.count(level), 25U) << level;
}

TEST(Design, ReplicatesOfALatinHypercubeKeepRangesAndRedrawDistributions) {
    const Design design =
        design_of("[factors]\nbond_damping = { from = 0, to = 100 }\n" + drawn_length +
                  "[design]\ntype = \"latin_hypercube\"\npoints = 10\n"
                  "replicates = 2\n");
    for (std::int64_t point = 0; point < 20; point += 2) {
        EXPECT_EQ(design.row(point)[0], design.row(point + 1)[0]);
        EXPECT_NE(design.row(point)[1], design.row(point + 1)[1]);
    }
}

TEST(Design, SobolPointsAreScaledToTheFactors) {
    const Design design = design_of("[factors]\nbond_damping = { from = 0, to = 100 }\n"
                                    "density_kg_m3 = { from = 100, to = 200 }\n"
                                    "[design]\ntype = \"sobol\"\npoints = 3\n");
    EXPECT_EQ(design.values, (std::vector<double>{50, 150, 75, 125, 25, 175}));
}

TEST(Design, SobolReplicatesRotateDistributionsOnly) {
    const Design design =
        design_of("[factors]\nbond_damping = { from = 0, to = 100 }\n" + drawn_length +
                  "[design]\ntype = \"sobol\"\npoints = 8\nreplicates = 2\n");
    for (std::int64_t point = 0; point < 16; point += 2) {
        EXPECT_EQ(design.row(point)[0], design.row(point + 1)[0]);
        EXPECT_NE(design.row(point)[1], design.row(point + 1)[1]);
    }
}

TEST(Design, ListKeepsItsPointsAndDrawsDistributions) {
    const Design design = design_of("[factors]\n" + drawn_length +
                                    "[design]\ntype = \"list\"\n[[design.point]]\n"
                                    "bond_damping = 3\n[[design.point]]\nbond_damping = 1\n");
    ASSERT_EQ(design.point_count(), 2);
    EXPECT_EQ(design.row(0)[0], 3.0);
    EXPECT_EQ(design.row(1)[0], 1.0);
    EXPECT_NE(design.row(0)[1], design.row(1)[1]);
}

TEST(Design, CaseTakesTheValuesOfItsPoint) {
    const StudyConfig config =
        config_of("[stem]\nbond_diameter_mm = 2\n[factors]\nlength_mm = [110, "
                  "220]\nspheres = [12, 23]\ntip_deflection_mm = [5]\n");
    const Design design = make_design(config);
    const run::CaseSpec spec = case_of_point(config, design, 3);
    EXPECT_EQ(spec.point, 3);
    EXPECT_EQ(spec.stem.sphere_count, 23);
    EXPECT_EQ(spec.stem.bond_length, 0.01);
    EXPECT_EQ(spec.stem.bond_outer_diameter, 2e-3);
    EXPECT_EQ(spec.tip_deflection, 5e-3);
}

TEST(Design, AMillionPointsAreMade) {
    const StudyConfig config =
        config_of("[factors]\nbond_damping = { from = 10, to = 200 }\n" + drawn_length +
                  "[design]\ntype = \"latin_hypercube\"\npoints = 1000000\n");
    const Design design = make_design(config);
    EXPECT_EQ(design.point_count(), 1'000'000);
    EXPECT_NO_THROW(check_points(config, design));
    const auto damping = [&](std::int64_t p) { return design.row(p)[0]; };
    double sum = 0.0;
    for (std::int64_t point = 0; point < design.point_count(); ++point)
        sum += damping(point);
    // With stratification the mean has an error of width/(√12 n^1.5), 5e-8. The tolerance is ten
    // times this, and rounding.
    EXPECT_NEAR(sum / 1e6, 105.0, 1e-6);
}

TEST(DesignCheck, ImpossiblePointsAreListedWithTheirValues) {
    const StudyConfig config =
        config_of("[factors]\nlength_mm = [100, 20]\ntip_deflection_mm = [15, "
                  "25]\n");
    try {
        check_points(config, make_design(config));
        FAIL() << "accepted";
    } catch (const core::InputError& error) {
        EXPECT_STREQ(error.what(),
                     "s.toml: 1 of 4 points are impossible:\n"
                     "  point 3: release.tip_deflection_mm = 25: must be smaller than the stem's "
                     "free length, 20 mm (length_mm = 20, tip_deflection_mm = 25)");
    }
}

TEST(DesignCheck, OnlyTheFirstTenPointsAreListed) {
    const StudyConfig config =
        config_of("[factors]\nbond_damping = { from = 1, to = 15, step = 1 }\n");
    try {
        check_points(config, make_design(config), [](const run::CaseSpec& spec) {
            return spec.stem.bond_damping > 2.0 ? std::optional<std::string>("too damp")
                                                : std::nullopt;
        });
        FAIL() << "accepted";
    } catch (const core::InputError& error) {
        const std::string text = error.what();
        EXPECT_EQ(text.substr(0, text.find('\n')), "s.toml: 13 of 15 points are impossible:");
        EXPECT_NE(text.find("\n  point 2: too damp (bond_damping = 3)\n"), std::string::npos);
        EXPECT_NE(text.find("\n  point 11: too damp (bond_damping = 12)\n"), std::string::npos);
        EXPECT_EQ(text.find("point 12:"), std::string::npos);
        EXPECT_EQ(text.substr(text.rfind('\n')), "\n  and 3 more");
    }
}

} // namespace
} // namespace culm::study
