// SPDX-License-Identifier: BSD-3-Clause
// The meaning of valid study files.
#include "study/config/study_config.hpp"

#include <gtest/gtest.h>

namespace culm::study {
namespace {

StudyConfig parsed(const std::string& text) {
    return parse_config(text, "dir/some.toml");
}

Levels levels_of(const std::string& factor) {
    return std::get<Levels>(parsed("[factors]\n" + factor).factors.at(0).values);
}

TEST(Config, EmptyFileIsThePaperStemWithEveryDefault) {
    const StudyConfig config = parsed("");
    EXPECT_EQ(config.name, "some");
    EXPECT_EQ(config.seed, 1U);
    EXPECT_EQ(config.base.store, run::StoreLevel::Tip);
    EXPECT_EQ(config.base.stem.sphere_count, 56);
    EXPECT_EQ(config.base.stem.bond_youngs_modulus, 1e9);
    EXPECT_EQ(config.base.tip_deflection, 15e-3);
    EXPECT_FALSE(config.base.law.shear_damping_torque);
    EXPECT_EQ(config.base.integrator.method, run::IntegrationMethod::Implicit);
    EXPECT_EQ(config.base.integrator.relative_tolerance, 2e-6);
    EXPECT_EQ(config.base.dimensions, 2);
    EXPECT_EQ(config.base.duration, 0.1);
    EXPECT_EQ(config.base.sample_interval, 5e-5);
    EXPECT_EQ(config.design.type, DesignType::Factorial);
    EXPECT_EQ(config.design.replicates, 1);
    EXPECT_FALSE(config.reduce.window.has_value());
    EXPECT_TRUE(config.reduce.is_amplitude_free);
    EXPECT_EQ(config.reduce.significance, 0.05);
    EXPECT_EQ(config.trajectory_compression, 0);
    EXPECT_TRUE(config.factors.empty());
}

TEST(Config, EverySectionIsRead) {
    const StudyConfig config = parsed(R"(
[study]
name = "all"
store = "heights"
heights_mm = [50, 100]
seed = 7
[stem]
spheres = 30
length_mm = 145
bond_diameter_mm = 3
bond_wall_mm = 0.5
axial_gravity_m_s2 = -9.81
[release]
tip_deflection_mm = 20
[law]
name = "consistent"
[integrator]
method = "explicit"
timestep_s = 1e-9
dimensions = 3
[vibration]
duration_s = 0.2
sample_interval_s = 1e-4
[reduce]
window_s = 0.15
amplitude = "fixed"
significance = 0.01
[archive]
trajectory_compression = 4
)");
    EXPECT_EQ(config.name, "all");
    EXPECT_EQ(config.seed, 7U);
    EXPECT_EQ(config.base.store, run::StoreLevel::Heights);
    EXPECT_EQ(config.base.heights, (std::vector<double>{0.05, 0.1}));
    EXPECT_EQ(config.base.stem.sphere_count, 30);
    EXPECT_DOUBLE_EQ(config.base.stem.bond_length, 5e-3); // one division's rounding
    EXPECT_EQ(config.base.stem.bond_inner_diameter, 2e-3);
    EXPECT_EQ(config.base.stem.axial_acceleration_of_gravity, -9.81);
    EXPECT_EQ(config.base.tip_deflection, 0.02);
    EXPECT_TRUE(config.base.law.shear_damping_torque);
    EXPECT_TRUE(config.base.law.lever_arms_follow_bond);
    EXPECT_EQ(config.base.integrator.method, run::IntegrationMethod::Explicit);
    EXPECT_EQ(config.base.integrator.timestep, 1e-9);
    EXPECT_EQ(config.base.dimensions, 3);
    EXPECT_EQ(config.base.duration, 0.2);
    EXPECT_EQ(config.base.sample_interval, 1e-4);
    EXPECT_EQ(config.reduce.window, 0.15);
    EXPECT_FALSE(config.reduce.is_amplitude_free);
    EXPECT_EQ(config.reduce.significance, 0.01);
    EXPECT_EQ(config.trajectory_compression, 4);
}

TEST(Config, FactorsKeepTheOrderOfTheFile) {
    const StudyConfig config =
        parsed("[factors]\ntip_deflection_mm = [10]\nbond_damping = [1]\nspheres = [9]\n");
    ASSERT_EQ(config.factors.size(), 3U);
    EXPECT_EQ(config.factors[0].parameter->key, "tip_deflection_mm");
    EXPECT_EQ(config.factors[1].parameter->key, "bond_damping");
    EXPECT_EQ(config.factors[2].parameter->key, "spheres");
}

TEST(Config, ListStepAndCountGiveTheSameLevels) {
    const Levels expected{25.0, 50.0, 75.0, 100.0};
    EXPECT_EQ(levels_of("bond_damping = [25, 50, 75, 100]"), expected);
    EXPECT_EQ(levels_of("bond_damping = { from = 25, to = 100, step = 25 }"), expected);
    EXPECT_EQ(levels_of("bond_damping = { from = 25, to = 100, count = 4 }"), expected);
}

TEST(Config, DecimalStepsReachTheEnd) {
    const Levels levels = levels_of("poissons_ratio = { from = 0.1, to = 0.4, step = 0.1 }");
    ASSERT_EQ(levels.size(), 4U);
    EXPECT_EQ(levels.front(), 0.1);
    EXPECT_EQ(levels.back(), 0.4);
    EXPECT_NEAR(levels[1], 0.2, 1e-16); // one rounding
}

TEST(Config, LogSpacingHasEqualRatios) {
    const Levels levels =
        levels_of("bond_damping = { from = 1, to = 1000, count = 4, spacing = \"log\" }");
    ASSERT_EQ(levels.size(), 4U);
    EXPECT_NEAR(levels[1], 10.0, 1e-13); // rounding of pow and of its exponent
    EXPECT_NEAR(levels[2], 100.0, 1e-12);
    EXPECT_EQ(levels[3], 1000.0);
}

TEST(Config, FactorValuesAreInSi) {
    EXPECT_EQ(levels_of("bond_youngs_modulus_gpa = [1, 4.23]"), (Levels{1e9, 4.23e9}));
    EXPECT_EQ(levels_of("tip_deflection_mm = [15]"), (Levels{0.015}));
    const StudyConfig config = parsed(
        "[factors]\nlength_mm = { distribution = \"normal\", mean = 156, sd = 4.5, min = 100 }\n");
    const auto& length = std::get<Distribution>(config.factors.at(0).values);
    EXPECT_EQ(length.mean(), 0.156);
    EXPECT_EQ(length.sd(), 0.0045);
    EXPECT_EQ(length.min(), 0.1);
    EXPECT_EQ(length.max(), 100.0); // the end of the parameter's own range, 100 m
    EXPECT_TRUE(config.factors.at(0).is_redrawn);
}

TEST(Config, SampledDesignsTakeRangesWithoutLevels) {
    const StudyConfig config = parsed("[factors]\nbond_damping = { from = 10, to = 20 }\n[design]\n"
                                      "type = \"latin_hypercube\"\npoints = 5\n");
    EXPECT_FALSE(config.factors.at(0).is_redrawn);
    EXPECT_EQ(config.factors.at(0).quantile(0.25), 12.5);
}

TEST(Config, ListPointsBecomeColumns) {
    const StudyConfig config = parsed("[design]\ntype = \"list\"\n"
                                      "[[design.point]]\nspheres = 20\nbond_damping = 2\n"
                                      "[[design.point]]\nbond_damping = 3\nspheres = 30\n");
    EXPECT_EQ(config.design.points, 2);
    ASSERT_EQ(config.factors.size(), 2U);
    EXPECT_EQ(std::get<Levels>(config.factors[0].values), (Levels{20.0, 30.0}));
    EXPECT_EQ(std::get<Levels>(config.factors[1].values), (Levels{2.0, 3.0}));
}

TEST(Config, AConstraintOnASweptParameterWaitsForThePoints) {
    EXPECT_NO_THROW((void)parsed("[release]\ntip_deflection_mm = 200\n"
                                 "[factors]\nlength_mm = [300, 400]\n"));
}

} // namespace
} // namespace culm::study
