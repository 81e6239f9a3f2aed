// SPDX-License-Identifier: BSD-3-Clause
// Changes of the chain's coefficients by effects of the stem, against hand-written laws.
#include "core/error.hpp"
#include "effect_bench.hpp"
#include "physics/effects/stem_scales.hpp"

#include <cmath>
#include <complex>
#include <numbers>

#include <gtest/gtest.h>

namespace culm::physics {
namespace {

TEST(Taper, ScalesSectionAndMassWithTheDiameter) {
    const EffectBench bench({active("taper", {-0.4})});
    const BondCoefficients<double> plain = bench.plain_bond();
    ASSERT_EQ(bench.model.bonds.size(), 55U);
    for (std::size_t j = 0; j < 55; ++j) {
        const double scale = 1.0 - 0.4 * (bench.place_of_bond(j) - 0.5);
        const BondCoefficients<double>& bond = bench.model.bonds[j];
        expect_relative(bond.normal_stiffness, plain.normal_stiffness * std::pow(scale, 2));
        expect_relative(bond.shear_stiffness, plain.shear_stiffness * std::pow(scale, 2));
        expect_relative(bond.bending_stiffness, plain.bending_stiffness * std::pow(scale, 4));
        expect_relative(bond.torsion_stiffness, plain.torsion_stiffness * std::pow(scale, 4));
        // √(m k): both grow as the square; √(J k): both as the fourth power.
        expect_relative(bond.normal_damping, plain.normal_damping * std::pow(scale, 2));
        expect_relative(bond.bending_damping, plain.bending_damping * std::pow(scale, 4));
        EXPECT_EQ(bond.length, plain.length);
        EXPECT_EQ(bond.span, plain.span);
    }
    for (std::size_t i = 0; i < 56; ++i) {
        const double scale = 1.0 - 0.4 * (static_cast<double>(i) / 55.0 - 0.5);
        expect_relative(bench.model.spheres[i].mass, bench.stem.sphere_mass() * scale * scale);
    }
}

TEST(Taper, LeavesTheMiddleAndAddsOnlyTheSquareOfTheChangeToTheMass) {
    const double change = -0.3;
    const EffectBench bench({active("taper", {change})}, 57);
    expect_relative(bench.model.spheres[28].mass, bench.stem.sphere_mass());
    // Σ (1 + r (i/56 − 1/2))² over 57 spheres: 57 + r² Σ (i/56 − 1/2)², the latter 57·58/(12·56).
    const double expected =
        bench.stem.sphere_mass() * (57.0 + change * change * 57.0 * 58.0 / (12.0 * 56.0));
    expect_relative(bench.mass(), expected);
}

TEST(StiffnessGradient, ChangesStiffnessLinearlyAndItsDampingByTheRoot) {
    const EffectBench bench({active("stiffness_gradient", {0.6})});
    const BondCoefficients<double> plain = bench.plain_bond();
    for (std::size_t j = 0; j < 55; ++j) {
        const double factor = 1.0 + 0.6 * (bench.place_of_bond(j) - 0.5);
        const BondCoefficients<double>& bond = bench.model.bonds[j];
        expect_relative(bond.bending_stiffness, factor * plain.bending_stiffness);
        expect_relative(bond.shear_stiffness, factor * plain.shear_stiffness);
        expect_relative(bond.bending_damping, std::sqrt(factor) * plain.bending_damping);
        expect_relative(bond.shear_damping, std::sqrt(factor) * plain.shear_damping);
    }
    expect_relative(bench.mass(), 56.0 * bench.stem.sphere_mass());
}

TEST(StiffnessGradient, WorksWithoutDamping) {
    EffectBench bench({});
    bench.stem.bond_damping = 0.0;
    bench.model = plain_chain(bench.stem, bench.law);
    EffectTarget target{bench.stem, bench.law, bench.model, bench.camera};
    apply_effects(std::vector{active("stiffness_gradient", {0.6})}, target);
    EXPECT_EQ(bench.model.bonds[3].bending_damping, 0.0);
}

/// Compliance beyond that of the plain stem, rad/(N m), and its centre over the length.
struct ExtraCompliance {
    double sum = 0.0;
    double centre = 0.0;
};

ExtraCompliance extra_compliance(const EffectBench& bench) {
    ExtraCompliance extra;
    for (std::size_t j = 0; j < bench.model.bonds.size(); ++j) {
        const double more = 1.0 / bench.model.bonds[j].bending_stiffness -
                            1.0 / bench.plain_bond().bending_stiffness;
        extra.sum += more;
        extra.centre += more * bench.place_of_bond(j);
    }
    extra.centre /= extra.sum;
    return extra;
}

TEST(LocalDefect, AddsTheComplianceOfItsSegmentForAnyNumberOfSpheres) {
    const double length = StemParameters<double>{}.free_length();
    for (const int spheres : {15, 56, 200})
        for (const double place : {0.3, 0.41234, 0.7}) {
            const EffectBench bench({active("local_defect", {place * length, 0.5})}, spheres);
            const ExtraCompliance extra = extra_compliance(bench);
            // (1/f − 1) 0.03 L/(E I) with f = 1/2; the bell curve's tails beyond the ends are
            // below 1e-6 for 15 spheres, the coarsest.
            const double rigidity = bench.plain_bond().bending_stiffness * bench.stem.bond_length;
            expect_relative(extra.sum, 0.03 * length / rigidity, 1e-6);
            // The centre of a bell curve half a bond wide, summed at the bonds' middles, has an
            // error of up to exp(−2π²/4)/π = 0.23 % of a bond.
            EXPECT_NEAR(extra.centre, place, 0.0025 / static_cast<double>(spheres - 1));
        }
}

TEST(LocalDefect, DependsSmoothlyOnItsPosition) {
    // Bending stiffness of the bond nearest to the middle as the defect passes by in steps of a
    // fiftieth of a bond: second differences of a smooth function fall with the square of the
    // step, those at a kink only in proportion to it.
    const auto largest_bend = [](double step) {
        double largest = 0.0;
        const auto stiffness = [](double position) {
            return EffectBench({active("local_defect", {position, 0.5})})
                .model.bonds[27]
                .bending_stiffness;
        };
        for (double position = 0.074; position < 0.0815; position += step)
            largest =
                std::max(largest, std::abs(stiffness(position + step) - 2.0 * stiffness(position) +
                                           stiffness(position - step)));
        return largest;
    };
    const double bond = StemParameters<double>{}.bond_length;
    EXPECT_NEAR(largest_bend(bond / 50.0) / largest_bend(bond / 100.0), 4.0, 0.05);
}

TEST(Precurvature, IsTheMomentThatHoldsTheStemStraight) {
    const EffectBench bench({active("precurvature", {0.3, -0.1}), active("taper", {0.2})});
    ASSERT_EQ(bench.model.straight_moments.size(), 55U);
    for (std::size_t j = 0; j < 55; ++j) {
        const double curvature = 0.3 - 0.4 * bench.place_of_bond(j);
        const double diameter = 2.83e-3 * (1.0 + 0.2 * (bench.place_of_bond(j) - 0.5));
        const double rigidity = 1e9 * std::numbers::pi / 64.0 * std::pow(diameter, 4);
        expect_relative(bench.model.straight_moments[j], -rigidity * curvature);
    }
}

TEST(BendingLawEffects, ShareOneLaw) {
    const EffectBench bench(
        {active("out_of_plane", {0.04, 30.0}), active("bending_nonlinearity", {-0.02})});
    ASSERT_TRUE(bench.model.bending);
    EXPECT_EQ(bench.model.bending->cubic, -0.02);
    EXPECT_EQ(bench.model.bending->split, 0.04);
    expect_relative(bench.model.bending->angle, std::numbers::pi / 6.0);
}

TEST(Relaxation, KeepsTheShareThatRemainsAfterTheHold) {
    const EffectBench bench({active("relaxation", {0.03, 0.15, 0.45})});
    ASSERT_EQ(bench.model.branches.size(), 1U);
    EXPECT_EQ(bench.model.branches[0].relative_stiffness, 0.03);
    EXPECT_EQ(bench.model.branches[0].relaxation_time, 0.15);
    expect_relative(bench.model.branches[0].held_share, std::exp(-3.0));
}

/// Modulus of a spring in parallel with these branches, over the spring's, at a frequency in Hz.
std::complex<double> modulus_of(const std::vector<MaxwellBranch<double>>& branches,
                                double frequency) {
    std::complex<double> modulus = 1.0;
    for (const MaxwellBranch<double>& branch : branches) {
        const std::complex<double> x(0.0,
                                     2.0 * std::numbers::pi * frequency * branch.relaxation_time);
        modulus += branch.relative_stiffness * x / (1.0 + x);
    }
    return modulus;
}

/// E''/E'.
double loss_factor_of(const std::vector<MaxwellBranch<double>>& branches, double frequency) {
    const std::complex<double> modulus = modulus_of(branches, frequency);
    return modulus.imag() / modulus.real();
}

// Modes 1 to 3 are at 1, 6.27 and 17.5 times the first frequency.
TEST(FractionalZener, HasTheModulusOfColeAndCole) {
    constexpr double fraction = 0.1;
    for (const double exponent : {0.1, 0.3, 0.5, 0.8})
        for (const double decades : {-1.0, 0.0, 1.5}) {
            const double first = first_frequency(EffectBench({}).stem);
            const double time = std::pow(10.0, decades) / (2.0 * std::numbers::pi * first);
            const EffectBench bench({active("fractional_zener", {fraction, time, exponent, 0.3})});
            for (double ratio = 0.7; ratio <= 20.0; ratio *= 1.1) {
                const std::complex<double> power =
                    std::pow(std::complex<double>(0.0, ratio * std::pow(10.0, decades)), exponent);
                const std::complex<double> wanted = fraction * power / (1.0 + power);
                const std::complex<double> found =
                    modulus_of(bench.model.branches, ratio * first) - 1.0;
                EXPECT_LT(std::abs(found - wanted), 0.03 * std::abs(wanted))
                    << exponent << " " << decades << " " << ratio;
            }
            double sum = 0.0;
            for (const MaxwellBranch<double>& branch : bench.model.branches) {
                EXPECT_GE(branch.relative_stiffness, 0.0);
                expect_relative(branch.held_share, std::exp(-0.3 / branch.relaxation_time));
                sum += branch.relative_stiffness;
            }
            EXPECT_LT(sum, fraction); // faster relaxation than that of the branches is omitted
        }
}

TEST(HystereticDamping, LosesTheSameShareAtEveryFrequencyOfTheBand) {
    for (const double loss : {0.005, 0.02, 0.1, 0.3, 0.5}) {
        const EffectBench bench({active("hysteretic_damping", {loss})});
        ASSERT_EQ(bench.model.branches.size(), 6U);
        const double first = first_frequency(bench.stem);
        double worst = 0.0;
        for (double ratio = 0.5; ratio <= 20.0; ratio *= 1.02)
            worst = std::max(
                worst, std::abs(loss_factor_of(bench.model.branches, ratio * first) / loss - 1.0));
        // Modes 1 to 3 are at 1, 6.27 and 17.5. The error is usually 0.3 %, at most 0.8 % (at 0.5).
        EXPECT_LT(worst, 0.01) << loss;
        for (const MaxwellBranch<double>& branch : bench.model.branches) {
            EXPECT_GT(branch.relative_stiffness, 0.0); // a negative one would add energy
            EXPECT_EQ(branch.held_share, 0.0);
        }
    }
}

TEST(HystereticDamping, VanishesWithoutLoss) {
    for (const MaxwellBranch<double>& branch :
         EffectBench({active("hysteretic_damping", {0.0})}).model.branches)
        EXPECT_EQ(branch.relative_stiffness, 0.0);
}

TEST(StemScales, FirstFrequencyIsThatOfTheReferenceStem) {
    // The slowest mode of the 56 spheres is near 55.6 Hz at 1 GPa; the beam has half a sphere's
    // mass less at its tip, and neither shear nor rotatory inertia.
    EXPECT_NEAR(first_frequency(StemParameters<double>{}), 55.6, 0.04 * 55.6);
}

TEST(AttachedMass, KeepsSumAndCentreAndRefusesAPositionBelowTheClamp) {
    EffectBench bench({});
    const double place = 0.1;
    EffectTarget target{bench.stem, bench.law, bench.model, bench.camera, {{place, 4e-6}}};
    apply_effects({}, target);
    double mass = 0.0;
    double moment = 0.0;
    for (std::size_t i = 0; i < bench.model.spheres.size(); ++i) {
        const double more = bench.model.spheres[i].mass - bench.stem.sphere_mass();
        mass += more;
        moment += more * static_cast<double>(i) * bench.stem.bond_length;
    }
    // Rounding of sums of 56 masses.
    expect_relative(mass, 4e-6, 1e-12);
    expect_relative(moment, 4e-6 * place, 1e-12);
    target.attached = {{-0.01, 4e-6}};
    EXPECT_THROW(apply_effects({}, target), core::InputError);
}

} // namespace
} // namespace culm::physics
