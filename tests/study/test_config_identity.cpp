// SPDX-License-Identifier: BSD-3-Clause
// The identity of a study, and the description of differences.
#include "study/config/study_config.hpp"

#include <gtest/gtest.h>

namespace culm::study {
namespace {

std::string identity_of(const std::string& text) {
    return parse_config(text, "s.toml").identity();
}

TEST(ConfigIdentity, NameCommentsOrderAndCompressionDoNotMatter) {
    EXPECT_EQ(identity_of("[stem]\nspheres = 20\nbond_damping = 5\n"),
              identity_of("# a comment\n[archive]\ntrajectory_compression = 3\n[study]\nname = "
                          "\"x\"\n[stem]\nbond_damping = 5.0\nspheres = 20\n"));
}

TEST(ConfigIdentity, WritingDefaultsOutDoesNotMatter) {
    EXPECT_EQ(identity_of(""),
              identity_of("[study]\nstore = \"tip\"\nseed = 1\n[stem]\nspheres = 56\n"
                          "sphere_diameter_mm = 2.83\nbond_length_mm = 2.83\n"
                          "bond_inner_diameter_mm = 0\ndensity_kg_m3 = 125\npoissons_ratio = 0.3\n"
                          "[law]\nname = \"schramm2019\"\n[integrator]\n"
                          "method = \"implicit\"\nrelative_tolerance = 2e-6\n[vibration]\n"
                          "duration_s = 0.1\n[design]\ntype = \"factorial\"\nreplicates = 1\n"
                          "[reduce]\nwindow_s = 0.1\nsignificance = 0.05\n"));
}

TEST(ConfigIdentity, AListAndTheSameRangeAreOneStudy) {
    EXPECT_EQ(identity_of("[factors]\nbond_damping = [25, 50, 75]\n"),
              identity_of("[factors]\nbond_damping = { from = 25, to = 75, step = 25 }\n"));
}

TEST(ConfigIdentity, LinesAreSortedAndComplete) {
    EXPECT_EQ(
        identity_of("[stem]\nlength_mm = 110\nspheres = 12\nbond_diameter_mm = "
                    "5\n[factors]\nbond_damping = [1, 2]\n"
                    "bond_youngs_modulus_gpa = { distribution = \"normal\", mean = 4, sd = 1, "
                    "min = 1, max = 7 }\n"),
        "archive.trajectory_precision = float64\n"
        "design.replicates = 1\n"
        "design.type = factorial\n"
        "factors = bond_damping, bond_youngs_modulus_gpa\n"
        "factors.bond_damping = [1, 2]\n"
        "factors.bond_youngs_modulus_gpa = normal, mean 4, sd 1, min 1, max 7\n"
        "integrator.dimensions = 2\n"
        "integrator.method = implicit\n"
        "integrator.relative_tolerance = 2e-06\n"
        "law.name = schramm2019\n"
        "reduce.amplitude = free\n"
        "reduce.significance = 0.05\n"
        "reduce.window_s = 0.1\n"
        "release.tip_deflection_mm = 15\n"
        "replicates.within = 1\n"
        "stem.axial_gravity_m_s2 = 0\n"
        "stem.bond_diameter_mm = 5\n"
        "stem.bond_inner_diameter_mm = 0\n"
        "stem.bond_length_mm = 10\n"
        "stem.density_kg_m3 = 31.25\n"
        "stem.poissons_ratio = 0.3\n"
        "stem.sphere_diameter_mm = 10\n"
        "stem.spheres = 12\n"
        "study.kind = vibration\n"
        "study.seed = 1\n"
        "study.store = tip\n"
        "vibration.duration_s = 0.1\n"
        "vibration.sample_interval_s = 5e-05\n");
}

TEST(ConfigIdentity, EverythingThatInfluencesResultsMatters) {
    const std::string reference =
        identity_of("[factors]\nbond_damping = [1, 2]\nspheres = [9, 10]\n");
    for (const char* addition :
         {"[study]\nseed = 2\n", "[study]\nstore = \"full\"\n",
          "[study]\nstore = \"full\"\nheights_mm = [5]\n", "[stem]\ndensity_kg_m3 = 126\n",
          "[stem]\nbond_diameter_mm = 2.5\n", "[stem]\nlength_mm = 30\n",
          "[release]\ntip_deflection_mm = 14\n", "[law]\nname = \"consistent\"\n",
          "[integrator]\nrelative_tolerance = 1e-7\n", "[integrator]\ndimensions = 3\n",
          "[integrator]\nmethod = \"explicit\"\ntimestep_s = 1e-10\n",
          "[vibration]\nduration_s = 0.2\n", "[vibration]\nsample_interval_s = 1e-4\n",
          "[reduce]\nwindow_s = 0.05\n", "[reduce]\namplitude = \"fixed\"\n"})
        EXPECT_NE(identity_of(std::string("[factors]\nbond_damping = [1, 2]\nspheres = [9, 10]\n") +
                              addition),
                  reference)
            << addition;
    EXPECT_NE(identity_of("[factors]\nspheres = [9, 10]\nbond_damping = [1, 2]\n"), reference)
        << "the order of the factors numbers the points";
}

TEST(ConfigIdentity, ABondLengthThatIsGivenIsNotOneThatFollowsASweptSphere) {
    EXPECT_NE(
        identity_of("[factors]\nsphere_diameter_mm = [2, 3]\n"),
        identity_of("[stem]\nbond_length_mm = 2.83\n[factors]\nsphere_diameter_mm = [2, 3]\n"));
}

TEST(ConfigIdentity, DifferenceNamesEachChangedKey) {
    const std::string stored = identity_of("[factors]\nbond_damping = [25, 50]\n");
    const std::string now = identity_of("[integrator]\nmethod = \"explicit\"\ntimestep_s = 1e-10\n"
                                        "[factors]\nbond_damping = [25, 75]\n");
    EXPECT_EQ(difference(stored, now),
              "factors.bond_damping: stored [25, 50], now [25, 75]\n"
              "integrator.method: stored implicit, now explicit\n"
              "integrator.relative_tolerance: stored 2e-06, not in the study now\n"
              "integrator.timestep_s: not in the stored study, now 1e-10\n");
    EXPECT_EQ(difference(stored, stored), "");
}

} // namespace
} // namespace culm::study
