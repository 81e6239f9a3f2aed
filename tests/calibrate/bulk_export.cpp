// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/bulk_export.hpp"

#include "core/error.hpp"
#include "physics/bond_coefficients.hpp"

#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace {

using namespace culm;

// How the authors' code is told the bond parameters (README of the reference trajectories): "One
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

/// Words of the only line that begins like that.
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

TEST(LiggghtsLines, StandInTheOrderThatTheAuthorsCodeReads) {
    calibrate::BulkStem bulk = paper_stem("schramm2019");
    bulk.stem.bond_inner_diameter = 0.5 * bulk.stem.bond_outer_diameter;
    bulk.stem.bond_damping = 12.5;
    const std::vector<std::string> words =
        words_of_line(calibrate::liggghts_lines(bulk), "bond_coeff");
    const std::vector<double> wanted{1, 1, 0.5, 1e9, 1e9 / 2.6, 1, 12.5, 1, 1e32, 1e32};
    ASSERT_EQ(words.size(), wanted.size() + 1);
    for (std::size_t k = 0; k < wanted.size(); ++k)
        EXPECT_NEAR(std::stod(words[k + 1]), wanted[k], 1e-8 * wanted[k]) << k; // nine digits
}

TEST(LiggghtsLines, NameTheStepThatTheReferenceRunsUsed) {
    calibrate::BulkStem bulk = paper_stem("schramm2019");
    bulk.stem.bond_damping = 5.0;
    // Its table: 4.970e-08 s at 1 GPa and beta 5, after shortening to a whole number of steps in
    // 5e-5 s (1006 of them, so by less than 0.1 %).
    EXPECT_NE(calibrate::liggghts_lines(bulk).find("4.97"), std::string::npos)
        << calibrate::liggghts_lines(bulk);
}

TEST(LammpsLines, CarryStiffnessesAndDampingOfTheBond) {
    const calibrate::BulkStem bulk = paper_stem("consistent");
    const auto bond = physics::make_bond_coefficients(bulk.stem, physics::consistent_law());
    const std::vector<std::string> words =
        words_of_line(calibrate::lammps_lines(bulk), "bond_coeff");
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

TEST(BulkLines, AreRefusedUnderTheOtherLaw) {
    EXPECT_THROW(static_cast<void>(calibrate::liggghts_lines(paper_stem("consistent"))),
                 core::InputError);
    EXPECT_THROW(static_cast<void>(calibrate::lammps_lines(paper_stem("schramm2019"))),
                 core::InputError);
}

TEST(BulkLines, SayThatSomethingIsMissing) {
    calibrate::BulkStem bulk = paper_stem("consistent");
    EXPECT_EQ(calibrate::lammps_lines(bulk).find("CAUTION"), std::string::npos);
    bulk.is_adequate = false;
    bulk.effects = {"gravity"};
    const std::string text = calibrate::lammps_lines(bulk);
    EXPECT_NE(text.find("something is missing"), std::string::npos);
    EXPECT_NE(text.find("together with gravity"), std::string::npos);
}

TEST(BulkLines, HalveTheTipWhereTheStemEndsAtItsCentre) {
    calibrate::BulkStem bulk = paper_stem("consistent");
    EXPECT_EQ(calibrate::lammps_lines(bulk).find("tips"), std::string::npos);
    bulk.stem.tip_mass_share = 0.5;
    EXPECT_NE(calibrate::lammps_lines(bulk).find("set group tips density 62.5"), std::string::npos);
}

} // namespace
