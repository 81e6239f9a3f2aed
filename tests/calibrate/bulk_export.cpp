// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/bulk_export.hpp"

#include "core/error.hpp"
#include "physics/bond_coefficients.hpp"
#include "physics/effects/library.hpp"

#include <cmath>
#include <cstdio>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace {

using namespace culm;

// Bond parameters in the input of the authors' code (README of the reference trajectories): "One
// `bond_coeff` line per bond type, values in SI, in this order: bond type number; outer bond
// diameter as a fraction of the particle diameter; inner bond diameter as a fraction of it (0 =
// solid); bond Young's modulus Y; bond shear modulus G; damping type (1 = the linear law above);
// damping coefficient beta; breakage type (1 = stress); critical normal stress; critical shear
// stress (1.0e32 = never)."

calibrate::BulkStem paper_stem(const std::string& law) {
    calibrate::BulkStem bulk;
    bulk.id = "paper";
    bulk.law = law;
    bulk.reduced_chi_squared = 1.0;
    return bulk;
}

std::string liggghts_lines(const calibrate::BulkStem& bulk) {
    calibrate::TypeNumbers next;
    return calibrate::liggghts_lines(bulk, next);
}
std::string
lammps_lines(const calibrate::BulkStem& bulk,
             calibrate::LammpsVersion version = calibrate::LammpsVersion::UpTo30March2026) {
    calibrate::TypeNumbers next;
    return calibrate::lammps_lines(bulk, version, next);
}

/// Words of the only line that has this beginning.
std::vector<std::string> words_of_line(const std::string& text, const std::string& beginning) {
    std::istringstream lines(text);
    std::vector<std::string> words;
    for (std::string line; std::getline(lines, line);) {
        if (!line.starts_with(beginning))
            continue;
        EXPECT_TRUE(words.empty()) << "twice: " << line;
        std::istringstream in(line);
        for (std::string word; in >> word;)
            words.push_back(word);
    }
    return words;
}

TEST(LiggghtsLines, HaveTheOrderThatTheAuthorsCodeReads) {
    calibrate::BulkStem bulk = paper_stem("schramm2019");
    bulk.stem.bond_inner_diameter = 0.5 * bulk.stem.bond_outer_diameter;
    bulk.stem.bond_damping = 12.5;
    const std::vector<std::string> words = words_of_line(liggghts_lines(bulk), "bond_coeff");
    const std::vector<double> wanted{1, 1, 0.5, 1e9, 1e9 / 2.6, 1, 12.5, 1, 1e32, 1e32};
    ASSERT_EQ(words.size(), wanted.size() + 1);
    for (std::size_t k = 0; k < wanted.size(); ++k)
        EXPECT_NEAR(std::stod(words[k + 1]), wanted[k], 1e-8 * wanted[k]) << k; // nine digits
}

// In the authors' code a stem with 10 mg at mid-height decays as in culm to 0.003 % with this
// correction, and 2.5 % faster without it (docs/export.md).
TEST(LiggghtsLines, GiveBondsNextToAnotherMassTheCalibratedDamping) {
    calibrate::BulkStem bulk = paper_stem("schramm2019");
    const double mass = bulk.stem.sphere_mass();
    bulk.added_masses = {{30.0 * bulk.stem.bond_length, 3.0 * mass}}; // sphere 31 of four masses
    const std::string text = liggghts_lines(bulk);
    for (const char* line : {"bond_coeff 2 ", "bond_coeff 3 ", "group bond30 id 30 31\n",
                             "set group bond30 bond 2\n", "set group bond31 bond 3\n"})
        EXPECT_NE(text.find(line), std::string::npos) << line << text;
    EXPECT_EQ(text.find("bond_coeff 4"), std::string::npos);
    const std::vector<std::string> words = words_of_line(text, "bond_coeff 2");
    ASSERT_EQ(words.size(), 11U);
    // The reduced mass of m and 4m is 8/5 of that of two m.
    EXPECT_NEAR(std::stod(words[7]), bulk.stem.bond_damping / std::sqrt(1.6), 1e-6);
}

TEST(BulkLines, NumberTheTypesOfSeveralStems) {
    calibrate::TypeNumbers next;
    static_cast<void>(calibrate::liggghts_lines(paper_stem("schramm2019"), next));
    const std::string second = calibrate::liggghts_lines(paper_stem("schramm2019"), next);
    EXPECT_NE(second.find("set type 2 "), std::string::npos);
    EXPECT_NE(second.find("bond_coeff 2 "), std::string::npos);
}

TEST(LiggghtsLines, NameTheStepThatTheReferenceRunsUsed) {
    calibrate::BulkStem bulk = paper_stem("schramm2019");
    bulk.stem.bond_damping = 5.0;
    // Its table: 4.970e-08 s at 1 GPa and beta 5, after shortening to a whole number of steps in
    // 5e-5 s (1006 of them, so by less than 0.1 %).
    EXPECT_NE(liggghts_lines(bulk).find("4.97"), std::string::npos) << liggghts_lines(bulk);
}

TEST(LammpsLines, CarryStiffnessesAndDampingOfTheBond) {
    const calibrate::BulkStem bulk = paper_stem("consistent");
    const auto bond = physics::make_bond_coefficients(bulk.stem, physics::consistent_law());
    const std::vector<std::string> words = words_of_line(lammps_lines(bulk), "bond_coeff");
    const std::vector<double> wanted{1,
                                     bond.normal_stiffness,
                                     bond.shear_stiffness,
                                     bond.torsion_stiffness,
                                     bond.bending_stiffness,
                                     bond.normal_stiffness * bond.length,
                                     1e32,
                                     1e32,
                                     1e32,
                                     bond.normal_damping,
                                     bond.shear_damping,
                                     2 * bond.bending_damping / bond.length,
                                     2 * bond.torsion_damping};
    ASSERT_EQ(words.size(), wanted.size() + 1);
    for (std::size_t k = 0; k < wanted.size(); ++k)
        EXPECT_NEAR(std::stod(words[k + 1]), wanted[k], 1e-8 * wanted[k]) << k; // nine digits
}

// Manual of LAMMPS, bond_style bpm/rotational: "The previous implementation (up to LAMMPS version
// 30Mar2026) can be recovered by setting frame to particle and damping to dem, and swapping the
// third and fourth damping factors."
TEST(LammpsLines, NameTheFormerDampingFromJuly2026On) {
    const calibrate::BulkStem bulk = paper_stem("consistent");
    const std::string former = lammps_lines(bulk);
    const std::string now = lammps_lines(bulk, calibrate::LammpsVersion::From4July2026);
    EXPECT_EQ(former.find("frame"), std::string::npos);
    EXPECT_NE(now.find("bond_style bpm/rotational break no smooth no frame particle damping dem\n"),
              std::string::npos);
    auto words = words_of_line(now, "bond_coeff");
    std::swap(words.at(12), words.at(13));
    EXPECT_EQ(words, words_of_line(former, "bond_coeff"));
}

TEST(BulkLines, AreRefusedUnderTheOtherLaw) {
    EXPECT_THROW(static_cast<void>(liggghts_lines(paper_stem("consistent"))), core::InputError);
    EXPECT_THROW(static_cast<void>(lammps_lines(paper_stem("schramm2019"))), core::InputError);
}

TEST(BulkLines, SayThatTheModelIsInadequate) {
    calibrate::BulkStem bulk = paper_stem("consistent");
    EXPECT_EQ(lammps_lines(bulk).find("CAUTION"), std::string::npos);
    bulk.is_adequate = false;
    EXPECT_NE(lammps_lines(bulk).find("model inadequate"), std::string::npos);
}

TEST(BulkLines, HalveTheTipWhereTheStemEndsAtItsCentre) {
    calibrate::BulkStem bulk = paper_stem("consistent");
    EXPECT_EQ(lammps_lines(bulk).find("set atom"), std::string::npos);
    bulk.stem.tip_mass_share = 0.5;
    EXPECT_NE(lammps_lines(bulk).find("set atom 56 density 62.5"), std::string::npos);
}

/// Density by sphere of the lines `set atom N density D`.
std::map<int, double> densities(const std::string& text) {
    std::map<int, double> found;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        int sphere = 0;
        double density = 0.0;
        if (std::sscanf(line.c_str(), "set atom %d density %lf", &sphere, &density) == 2)
            found[sphere] = density;
    }
    return found;
}

// The stem of jobs/local.sh: half a sphere's mass is added at the tip, which itself has half.
TEST(BulkLines, AddAKnownMassToTheTip) {
    calibrate::BulkStem bulk = paper_stem("schramm2019");
    bulk.stem.tip_mass_share = 0.5;
    bulk.added_masses = {{bulk.stem.free_length(), 0.25 * bulk.stem.sphere_mass()}};
    const auto found = densities(liggghts_lines(bulk));
    ASSERT_EQ(found.size(), 1u);
    EXPECT_NEAR(found.at(56), 0.75 * bulk.stem.density, 1e-6);
    bulk.added_masses[0].mass *= 2.0; // now as heavy as every other sphere
    EXPECT_TRUE(densities(liggghts_lines(bulk)).empty());
}

TEST(BulkLines, ShareAMassBetweenTheSpheresAroundIt) {
    for (const bool is_lammps : {false, true}) {
        calibrate::BulkStem bulk = paper_stem(is_lammps ? "consistent" : "schramm2019");
        const double mass = 3.0 * bulk.stem.sphere_mass();
        bulk.added_masses = {{10.25 * bulk.stem.bond_length, mass}};
        const auto found = densities(is_lammps ? lammps_lines(bulk) : liggghts_lines(bulk));
        ASSERT_EQ(found.size(), 2u);
        // Sphere 1 is at height 0, so 10.25 bond lengths is a quarter from sphere 11 to 12.
        EXPECT_NEAR(found.at(11), (1.0 + 0.75 * 3.0) * bulk.stem.density, 1e-6);
        EXPECT_NEAR(found.at(12), (1.0 + 0.25 * 3.0) * bulk.stem.density, 1e-6);
    }
}

TEST(BulkLines, CarryTipMassAndGravity) {
    calibrate::BulkStem bulk = paper_stem("consistent");
    bulk.effects = {{"tip_mass", {{"mass_kg", bulk.stem.sphere_mass()}}},
                    {"gravity", {{"axial_m_s2", -3.0}, {"transverse_m_s2", 4.0}}}};
    const std::string text = lammps_lines(bulk);
    EXPECT_NEAR(densities(text).at(56), 2.0 * bulk.stem.density, 1e-6);
    EXPECT_NE(text.find("fix gravity all gravity 5 vector -0.6 0.8 0"), std::string::npos) << text;
}

TEST(BulkLines, RefuseEffectsThatTheCodeCannotExpress) {
    for (const std::string& name : physics::effect_names()) {
        if (name == "tip_mass" || name == "gravity")
            continue;
        std::vector<calibrate::BulkStem> stems{paper_stem("schramm2019")};
        stems[0].effects = {{name, {}}};
        try {
            static_cast<void>(liggghts_lines(stems[0]));
            FAIL() << name << " was not refused";
        } catch (const core::InputError& error) {
            EXPECT_NE(std::string(error.what()).find("--without " + name), std::string::npos);
        }
        calibrate::leave_out(stems, std::vector<std::string>{name});
        EXPECT_NE(liggghts_lines(stems[0]).find(name + ", which --without left out"),
                  std::string::npos);
    }
}

TEST(BulkLines, OmitKnownMassesOnRequest) {
    std::vector<calibrate::BulkStem> stems{paper_stem("consistent")};
    EXPECT_THROW(calibrate::leave_out(stems, std::vector<std::string>{"added_mass"}),
                 core::InputError); // it has none
    stems[0].added_masses = {{0.1, 1e-5}};
    calibrate::leave_out(stems, std::vector<std::string>{"added_mass"});
    const std::string text = lammps_lines(stems[0]);
    EXPECT_TRUE(densities(text).empty());
    EXPECT_NE(text.find("added_mass, which --without left out"), std::string::npos);
}

TEST(BulkLines, RefuseToOmitAnAbsentEffect) {
    std::vector<calibrate::BulkStem> stems{paper_stem("consistent")};
    stems[0].effects = {{"taper", {}}};
    try {
        calibrate::leave_out(stems, std::vector<std::string>{"tapr"});
        FAIL();
    } catch (const core::InputError& error) {
        EXPECT_NE(std::string(error.what()).find("did you mean \"taper\"?"), std::string::npos);
    }
}

} // namespace
