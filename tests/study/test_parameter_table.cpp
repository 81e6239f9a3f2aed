// SPDX-License-Identifier: BSD-3-Clause
// The parameter table: conversion, consistency, and defaults that depend on other parameters.
#include "study/config/parameters.hpp"

#include <numbers>

#include <gtest/gtest.h>

namespace culm::study {
namespace {

ParameterValues given(const std::vector<std::pair<const char*, double>>& values) {
    ParameterValues result;
    for (const auto& [key, value] : values) {
        const Parameter* parameter = find_parameter(key);
        EXPECT_NE(parameter, nullptr) << key;
        result.set(*parameter, parameter->unit.to_si(value));
    }
    return result;
}

run::CaseSpec case_with(const std::vector<std::pair<const char*, double>>& values) {
    run::CaseSpec spec;
    given(values).apply_to(spec);
    return spec;
}

double mass_per_length(const run::CaseSpec& spec) {
    return spec.stem.sphere_mass() / spec.stem.bond_length;
}

TEST(ParameterTable, EveryKeyNamesItsUnit) {
    for (const Parameter& p : parameters())
        if (!p.unit.suffix.empty()) {
            ASSERT_TRUE(core::split_key(p.key).unit.has_value()) << p.key;
            EXPECT_EQ(core::split_key(p.key).unit->suffix, p.unit.suffix) << p.key;
        }
}

TEST(ParameterTable, SetterAndGetterBelongToEachOther) {
    for (const Parameter& p : parameters()) {
        run::CaseSpec spec;
        const double value = p.is_whole_number ? 17.0 : 0.37 * p.get(spec) + 1e-4;
        p.set(spec, value);
        // Two roundings, of a product and a quotient or of a sum and a difference of like numbers.
        EXPECT_NEAR(p.get(spec), value, 1e-14 * std::abs(value) + 1e-17) << p.key;
    }
}

TEST(ParameterTable, DefaultsAreTable1OfThePaper) {
    const run::CaseSpec spec = case_with({});
    EXPECT_EQ(spec.stem.sphere_count, 56);
    EXPECT_EQ(spec.stem.sphere_diameter, 2.83e-3);
    EXPECT_EQ(spec.stem.bond_length, 2.83e-3);
    EXPECT_EQ(spec.stem.bond_outer_diameter, 2.83e-3);
    EXPECT_EQ(spec.stem.density, 125.0);
    EXPECT_EQ(spec.stem.poissons_ratio, 0.3);
    EXPECT_EQ(spec.tip_deflection, 15e-3);
}

TEST(ParameterTable, DefaultTextsAreTheDefaultsOfTheCase) {
    const run::CaseSpec spec;
    for (const Parameter& p : parameters()) {
        char* end = nullptr;
        const std::string text(p.default_text);
        const double value = std::strtod(text.c_str(), &end);
        if (end != text.c_str() && *end == '\0') {
            EXPECT_EQ(config_text(p, p.get(spec)), text) << p.key;
            EXPECT_EQ(p.unit.to_si(value), p.get(spec)) << p.key;
        }
    }
}

TEST(ParameterTable, ConfigTextGivesBackTheNumberThatWasRead) {
    const Parameter& diameter = *find_parameter("sphere_diameter_mm");
    const Parameter& modulus = *find_parameter("bond_youngs_modulus_gpa");
    for (const double value : {2.83, 0.1, 1.0 / 3.0, 155.65, 0.57}) {
        EXPECT_EQ(diameter.unit.to_si(std::stod(config_text(diameter, diameter.unit.to_si(value)))),
                  diameter.unit.to_si(value));
        EXPECT_EQ(modulus.unit.to_si(std::stod(config_text(modulus, modulus.unit.to_si(value)))),
                  modulus.unit.to_si(value));
    }
    EXPECT_EQ(config_text(diameter, 2.83e-3), "2.83");
}

TEST(ParameterTable, BondLengthAndDiameterFollowTheSphere) {
    const run::CaseSpec spec = case_with({{"sphere_diameter_mm", 2.0}});
    EXPECT_EQ(spec.stem.bond_length, 2e-3);
    EXPECT_EQ(spec.stem.bond_outer_diameter, 2e-3);
}

TEST(ParameterTable, KeepsGivenBondLengthAndDiameter) {
    const run::CaseSpec spec = case_with(
        {{"sphere_diameter_mm", 2.0}, {"bond_length_mm", 3.0}, {"bond_diameter_mm", 1.0}});
    EXPECT_EQ(spec.stem.sphere_diameter, 2e-3);
    EXPECT_EQ(spec.stem.bond_length, 3e-3);
    EXPECT_EQ(spec.stem.bond_outer_diameter, 1e-3);
}

TEST(ParameterTable, WallGivesTheInnerDiameter) {
    const run::CaseSpec spec = case_with({{"bond_diameter_mm", 2.57}, {"bond_wall_mm", 0.34}});
    EXPECT_NEAR(spec.stem.bond_inner_diameter, 1.89e-3, 1e-15); // one subtraction's rounding
}

TEST(ParameterTable, WallOfHalfTheDiameterIsSolid) {
    const run::CaseSpec spec = case_with({{"bond_diameter_mm", 2.83}, {"bond_wall_mm", 1.415}});
    EXPECT_EQ(spec.stem.bond_inner_diameter, 0.0);
}

TEST(ParameterTable, LengthKeepsTheMassPerLengthForAnyNumberOfSpheres) {
    // ρ π d²/6, the mass per length of touching spheres of the bond's diameter.
    const double expected = 125.0 * std::numbers::pi * 2.57e-3 * 2.57e-3 / 6.0;
    for (const double spheres : {10.0, 56.0, 200.0}) {
        const run::CaseSpec spec =
            case_with({{"spheres", spheres}, {"length_mm", 156.0}, {"bond_diameter_mm", 2.57}});
        EXPECT_NEAR(spec.stem.free_length(), 0.156, 1e-15);
        EXPECT_EQ(spec.stem.sphere_diameter, spec.stem.bond_length);
        EXPECT_NEAR(mass_per_length(spec), expected, 1e-13 * expected); // some ten roundings
    }
}

TEST(ParameterTable, ThePaperLengthGivesThePaperStem) {
    const run::CaseSpec spec = case_with({{"length_mm", 155.65}, {"bond_diameter_mm", 2.83}});
    // 155.65 mm/55 and the square of the ratio involve a few roundings.
    EXPECT_NEAR(spec.stem.sphere_diameter, 2.83e-3, 1e-17);
    EXPECT_NEAR(spec.stem.density, 125.0, 1e-12);
}

TEST(ParameterTable, LengthWithASphereDiameterLeavesSphereAndDensityAlone) {
    const run::CaseSpec spec = case_with({{"length_mm", 156.0}, {"sphere_diameter_mm", 2.5}});
    EXPECT_EQ(spec.stem.sphere_diameter, 2.5e-3);
    EXPECT_EQ(spec.stem.bond_outer_diameter, 2.5e-3);
    EXPECT_EQ(spec.stem.density, 125.0);
}

TEST(ParameterTable, ApplyingTwiceChangesNothing) {
    const ParameterValues values = given({{"length_mm", 100.0}, {"bond_wall_mm", 0.3}});
    run::CaseSpec spec;
    values.apply_to(spec);
    const double density = spec.stem.density;
    values.apply_to(spec);
    EXPECT_EQ(spec.stem.density, density);
}

} // namespace
} // namespace culm::study
