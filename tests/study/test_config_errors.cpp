// SPDX-License-Identifier: BSD-3-Clause
// The exact messages for invalid study files: sections other than the factors.
#include "refused.hpp"

#include <filesystem>

#include <gtest/gtest.h>

namespace culm::study {
namespace {

TEST(ConfigErrors, SyntaxErrorNamesTheLine) {
    const std::string text = refusal("[study]\nname = \n");
    EXPECT_EQ(text.substr(0, 27), "s.toml:2: not valid TOML: E") << text;
}

TEST(ConfigErrors, MissingFileIsNamed) {
    try {
        (void)load_config("no/such/study.toml");
        FAIL() << "accepted";
    } catch (const core::InputError& error) {
        EXPECT_STREQ(error.what(), "no/such/study.toml: cannot be read: No such file or directory");
    }
}

TEST(ConfigErrors, UnknownKeyGetsTheNearestName) {
    EXPECT_EQ(refusal("[stem]\nsphres = 56\n"),
              "s.toml:2: stem.sphres = 56: unknown key (did you mean spheres?)");
}

TEST(ConfigErrors, UnknownKeyWithoutANearOneGetsAllNames) {
    EXPECT_EQ(refusal("[vibration]\nx = 1\n"),
              "s.toml:2: vibration.x = 1: unknown key; allowed: duration_s, sample_interval_s");
}

TEST(ConfigErrors, UnknownSectionGetsTheNearestName) {
    EXPECT_EQ(refusal("[vibrations]\n"),
              "s.toml:1: vibrations: unknown table (did you mean vibration?)");
}

TEST(ConfigErrors, KeyOfAnotherSectionIsSentThere) {
    EXPECT_EQ(refusal("[stem]\ntip_deflection_mm = 15\n"),
              "s.toml:2: stem.tip_deflection_mm = 15: unknown key: tip_deflection_mm "
              "belongs into [release]");
    EXPECT_EQ(refusal("spheres = 56\n"),
              "s.toml:1: spheres = 56: unknown key: spheres belongs into [stem]");
}

TEST(ConfigErrors, WrongUnitGetsTheRightKeyAndTheConvertedValue) {
    EXPECT_EQ(refusal("[stem]\nbond_youngs_modulus_pa = 1.5e9\n"),
              "s.toml:2: stem.bond_youngs_modulus_pa = 1500000000: unknown key: the unit is GPa "
              "(write bond_youngs_modulus_gpa = 1.5)");
    EXPECT_EQ(refusal("[release]\ntip_deflection_m = 0.015\n"),
              "s.toml:2: release.tip_deflection_m = 0.015: unknown key: the unit is mm (write "
              "tip_deflection_mm = 15)");
    EXPECT_EQ(refusal("[vibration]\nduration_ms = 100\n"),
              "s.toml:2: vibration.duration_ms = 100: unknown key: the unit is s (write "
              "duration_s = 0.1)");
}

TEST(ConfigErrors, MissingUnitGetsTheRightKey) {
    EXPECT_EQ(refusal("[stem]\ndensity = 125\n"),
              "s.toml:2: stem.density = 125: unknown key: write density_kg_m3, in kg/m³");
}

TEST(ConfigErrors, SectionMustBeATable) {
    EXPECT_EQ(refusal("stem = 3\n"), "s.toml:1: stem = 3: must be a table: write [stem]");
}

TEST(ConfigErrors, WrongTypeNamesTheRightOne) {
    EXPECT_EQ(refusal("[stem]\nspheres = \"many\"\n"),
              "s.toml:2: stem.spheres = \"many\": must be a whole number in [2, 10000]");
    EXPECT_EQ(refusal("[stem]\nspheres = 56.5\n"),
              "s.toml:2: stem.spheres = 56.5: must be a whole number in [2, 10000]");
    EXPECT_EQ(refusal("[study]\nname = 3\n"), "s.toml:2: study.name = 3: must be text");
}

TEST(ConfigErrors, ImpossibleNumbersNameTheRange) {
    EXPECT_EQ(refusal("[stem]\nsphere_diameter_mm = -1\n"),
              "s.toml:2: stem.sphere_diameter_mm = -1: must be a number in (0, 1000] mm");
    EXPECT_EQ(refusal("[stem]\ndensity_kg_m3 = nan\n"),
              "s.toml:2: stem.density_kg_m3 = nan: must be a number in (0, 30000] kg/m³");
    EXPECT_EQ(refusal("[stem]\nbond_damping = inf\n"),
              "s.toml:2: stem.bond_damping = inf: must be a number in [0, 100000]");
    for (const char* ratio : {"0.5", "-1", "0.7"})
        EXPECT_EQ(refusal(std::string("[stem]\npoissons_ratio = ") + ratio),
                  std::string("s.toml:2: stem.poissons_ratio = ") + ratio +
                      ": must be a number in (-1, 0.5)");
}

TEST(ConfigErrors, WrongWordGetsTheNearestOne) {
    EXPECT_EQ(refusal("[study]\nstore = \"tips\"\n"),
              "s.toml:2: study.store = \"tips\": must be \"fit\", \"tip\", \"heights\" or \"full\" "
              "(did you mean \"tip\"?)");
    EXPECT_EQ(refusal("[law]\nname = \"schram2019\"\n"),
              "s.toml:2: law.name = \"schram2019\": must be \"schramm2019\" or \"consistent\" (did "
              "you mean \"schramm2019\"?)");
}

TEST(ConfigErrors, InnerDiameterMustBeSmallerThanTheOuter) {
    EXPECT_EQ(refusal("[stem]\nbond_diameter_mm = 2\nbond_inner_diameter_mm = 2\n"),
              "s.toml:3: stem.bond_inner_diameter_mm = 2: must be smaller than the bond diameter, "
              "2 mm");
    EXPECT_EQ(refusal("[stem]\nbond_wall_mm = 1.5\n"),
              "s.toml:2: stem.bond_wall_mm = 1.5: must be at most half of the bond diameter, "
              "2.83 mm");
}

TEST(ConfigErrors, DeflectionMustBeSmallerThanTheStem) {
    EXPECT_EQ(refusal("[release]\ntip_deflection_mm = 156\n"),
              "s.toml:2: release.tip_deflection_mm = 156: must be smaller than the stem's free "
              "length, 155.65 mm");
    EXPECT_EQ(refusal("[stem]\nlength_mm = 10\n"),
              "s.toml:2: release.tip_deflection_mm = 15: must be smaller than the stem's free "
              "length, 10 mm");
}

TEST(ConfigErrors, LengthAndBondLengthExcludeEachOther) {
    EXPECT_EQ(refusal("[stem]\nlength_mm = 100\nbond_length_mm = 2\n"),
              "s.toml:3: stem.bond_length_mm: not together with stem.length_mm, line 2");
    EXPECT_EQ(refusal("[stem]\nbond_inner_diameter_mm = 1\n[factors]\nbond_wall_mm = [0.3]\n"),
              "s.toml:2: stem.bond_inner_diameter_mm: not together with factors.bond_wall_mm, "
              "line 4");
}

TEST(ConfigErrors, HeightsBelongToTheirStoreLevels) {
    EXPECT_EQ(refusal("[study]\nheights_mm = [50]\n"),
              "s.toml:2: study.heights_mm = [50]: only with store = \"heights\" or \"full\"");
    EXPECT_EQ(refusal("[study]\nstore = \"heights\"\n"),
              "s.toml:1: study.heights_mm is missing: store = \"heights\" needs it");
    EXPECT_EQ(refusal("[study]\nstore = \"full\"\nheights_mm = [50, 50]\n"),
              "s.toml:3: study.heights_mm = [50, 50]: must name 50 once only");
    EXPECT_EQ(
        refusal("[study]\nstore = \"full\"\nheights_mm = [50, 300]\n"),
        "s.toml:3: study.heights_mm = 300: must not exceed the stem's free length, 155.65 mm");
    EXPECT_EQ(refusal("[study]\nstore = \"heights\"\nheights_mm = []\n"),
              "s.toml:3: study.heights_mm = []: must be a list of numbers in [0, 100000] mm");
}

TEST(ConfigErrors, TimesMustFitEachOther) {
    EXPECT_EQ(refusal("[vibration]\nsample_interval_s = 0.2\n"),
              "s.toml:2: vibration.sample_interval_s = 0.2: must not exceed duration_s = 0.1");
    EXPECT_EQ(refusal("[vibration]\nduration_s = 0.10001\n"),
              "s.toml:2: vibration.duration_s = 0.10001: duration_s = 0.10001 must be a multiple "
              "of sample_interval_s = 5e-05");
    EXPECT_EQ(refusal("[integrator]\nmethod = \"explicit\"\ntimestep_s = 3e-10\n"),
              "s.toml:3: integrator.timestep_s = 3e-10: must divide vibration.sample_interval_s = "
              "5e-05");
    EXPECT_EQ(refusal("[reduce]\nwindow_s = 0.2\n"),
              "s.toml:2: reduce.window_s = 0.2: must not exceed vibration.duration_s = 0.1");
}

TEST(ConfigErrors, IntegratorOptionsBelongToTheirMethod) {
    EXPECT_EQ(refusal("[integrator]\nmethod = \"explicit\"\n"),
              "s.toml:1: integrator.timestep_s is missing: method = \"explicit\" needs it");
    EXPECT_EQ(refusal("[integrator]\ntimestep_s = 1e-10\n"),
              "s.toml:2: integrator.timestep_s = 1e-10: only with method = \"explicit\"; "
              "implicit methods choose their steps by relative_tolerance");
    EXPECT_EQ(refusal("[study]\nkind = \"timestep\"\n[integrator]\nmethod = \"explicit\"\n"
                      "timestep_s = 1e-9\n"),
              "s.toml:4: integrator.method = \"explicit\": of a time-step study it is that of the "
              "reference run: \"implicit\" or \"sundials\"\n"
              "s.toml:5: integrator.timestep_s = 1e-09: only with study.kind = \"vibration\"");
    EXPECT_EQ(refusal("[integrator]\ndimensions = 4\n"),
              "s.toml:2: integrator.dimensions = 4: must be a whole number in [2, 3]");
}

TEST(ConfigErrors, AllErrorsComeAtOnceOrderedByLine) {
    EXPECT_EQ(refusal("[archive]\n"
                      "trajectory_compression = 10\n"
                      "[stem]\n"
                      "sphres = 56\n"
                      "density_kg_m3 = 0\n"
                      "[factors]\n"
                      "bond_damping = []\n"
                      "[study]\n"
                      "store = 1\n"),
              "s.toml:2: archive.trajectory_compression = 10: must be a whole number in [0, 9]\n"
              "s.toml:4: stem.sphres = 56: unknown key (did you mean spheres?)\n"
              "s.toml:5: stem.density_kg_m3 = 0: must be a number in (0, 30000] kg/m³\n"
              "s.toml:7: factors.bond_damping = []: must name at least one value\n"
              "s.toml:9: study.store = 1: must be \"fit\", \"tip\", \"heights\" or \"full\"");
}

TEST(ConfigErrors, AConstraintIsReportedTogetherWithErrorsElsewhere) {
    EXPECT_EQ(refusal("[study]\nstor = \"tip\"\n[release]\ntip_deflection_mm = 200\n"),
              "s.toml:2: study.stor = \"tip\": unknown key (did you mean store?)\n"
              "s.toml:4: release.tip_deflection_mm = 200: must be smaller than the stem's free "
              "length, 155.65 mm");
}

} // namespace
} // namespace culm::study
