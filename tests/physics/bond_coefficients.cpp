// SPDX-License-Identifier: BSD-3-Clause
// The coefficients against the formulas of the paper, written out by hand.
#include "physics/bond_coefficients.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace culm::physics {
namespace {

constexpr double pi = 3.14159265358979323846;
// Both sides evaluate the same few products; they may differ by rounding.
constexpr double rounding = 1e-14;

StemParameters<double> hollow_stem() {
    StemParameters<double> stem;
    stem.bond_outer_diameter = 2.57e-3;
    stem.bond_inner_diameter = 1.89e-3;
    stem.bond_youngs_modulus = 4.0e9;
    stem.bond_damping = 150.0;
    return stem;
}

void expect_relative(double value, double expected) {
    EXPECT_NEAR(value, expected, rounding * std::abs(expected));
}

TEST(BondCoefficients, MassOfTheReferenceSphereIsThatOfThePublicCode) {
    // The README of the reference data states 1.48343e-6 kg, with six digits.
    EXPECT_NEAR(StemParameters<double>{}.sphere_mass(), 1.48343e-6, 5e-12);
}

TEST(BondCoefficients, StiffnessesAreThoseOfEquation11TimesAreaAndMoments) {
    const auto stem = hollow_stem();
    const auto bond = make_bond_coefficients(stem, schramm2019_law());
    const double outer = 2.57e-3;
    const double inner = 1.89e-3;
    const double length = 2.83e-3;
    const double area = pi / 4 * (outer * outer - inner * inner);
    const double moment = pi / 64 * (std::pow(outer, 4) - std::pow(inner, 4));
    const double shear_modulus = 4.0e9 / (2 * 1.3);
    expect_relative(bond.normal_stiffness, 4.0e9 * area / length);
    expect_relative(bond.shear_stiffness, shear_modulus * area / length);
    expect_relative(bond.torsion_stiffness, shear_modulus * 2 * moment / length);
    expect_relative(bond.bending_stiffness, 4.0e9 * moment / length);
}

TEST(BondCoefficients, DampingIsTwiceBetaTimesTheRootOfReducedInertiaAndStiffness) {
    const auto stem = hollow_stem();
    const auto bond = make_bond_coefficients(stem, schramm2019_law());
    const double mass = 125.0 * pi / 6 * std::pow(2.83e-3, 3);
    const double inertia = 0.4 * mass * std::pow(2.83e-3 / 2, 2);
    expect_relative(bond.normal_damping, 300.0 * std::sqrt(mass / 2 * bond.normal_stiffness));
    expect_relative(bond.shear_damping, 300.0 * std::sqrt(mass / 2 * bond.shear_stiffness));
    expect_relative(bond.torsion_damping, 300.0 * std::sqrt(inertia / 2 * bond.torsion_stiffness));
    expect_relative(bond.bending_damping, 300.0 * std::sqrt(inertia / 2 * bond.bending_stiffness));
}

TEST(BondCoefficients, FactorAndInertiaOfTheLawAreHonoured) {
    const auto stem = hollow_stem();
    const auto paper = make_bond_coefficients(stem, schramm2019_law());
    BondLawOptions guo = schramm2019_law();
    guo.damping_factor = std::sqrt(2.0);
    expect_relative(make_bond_coefficients(stem, guo).bending_damping,
                    paper.bending_damping / std::sqrt(2.0));
    BondLawOptions individual = schramm2019_law();
    individual.damping_inertia = DampingInertia::Individual;
    expect_relative(make_bond_coefficients(stem, individual).shear_damping,
                    paper.shear_damping * std::sqrt(2.0));
}

TEST(BondCoefficients, DampingTimesOfShearAndBendingHaveTheRatioThatThePublicCodeStates) {
    // τ_s/τ_b = √(1.3/0.8) = 1.275 for equal touching spheres and ν = 0.3 (reference README).
    StemParameters<double> stem;
    const auto bond = make_bond_coefficients(stem, schramm2019_law());
    const double bending_time = bond.bending_damping / bond.bending_stiffness;
    const double shear_time = bond.shear_damping / bond.shear_stiffness;
    expect_relative(shear_time / bending_time, std::sqrt(1.3 / 0.8));
}

TEST(BondLawNames, OnlyTheTwoNamedLawsExist) {
    EXPECT_TRUE(law_by_name("schramm2019").has_value());
    EXPECT_FALSE(law_by_name("schramm2019")->shear_damping_torque);
    EXPECT_TRUE(law_by_name("consistent")->shear_damping_torque);
    EXPECT_FALSE(law_by_name("Consistent").has_value());
}

} // namespace
} // namespace culm::physics
