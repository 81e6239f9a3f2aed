// SPDX-License-Identifier: BSD-3-Clause
#include "fit/chain/stem_chain.hpp"

#include "core/error.hpp"
#include "physics/effects/library.hpp"
#include "physics/effects/stem_scales.hpp"
#include "run/case_model.hpp"
#include "run/modes.hpp"
#include "support/simulated_measurement.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Core>
#include <Eigen/LU>
#include <gtest/gtest.h>
#include <unsupported/Eigen/MatrixFunctions>

namespace {

using namespace culm;

TEST(StemChain, KeepsLengthAndMassPerLengthForAnyNumberOfSpheres) {
    const measure::Measurement measurement = tests::empty_measurement();
    for (const int spheres : {10, 56, 113}) {
        const auto spec = fit::chain_of(measurement, {spheres, {}}).spec;
        // Rounding only.
        EXPECT_NEAR(spec.stem.free_length(), measurement.stem.length, 1e-15);
        EXPECT_NEAR(spec.stem.sphere_mass() / spec.stem.bond_length,
                    measure::mass_per_length(measurement.stem), 1e-16);
    }
}

TEST(StemChain, EqualsThePapersChainForThePapersStem) {
    measure::Measurement measurement = tests::empty_measurement();
    measurement.stem.spheres.reset();
    const physics::StemParameters<double> stem = fit::chain_of(measurement).spec.stem;
    const physics::StemParameters<double> paper;
    EXPECT_EQ(stem.sphere_count, paper.sphere_count);
    EXPECT_NEAR(stem.bond_length, paper.bond_length, 1e-15); // rounding
    EXPECT_NEAR(stem.sphere_mass(), paper.sphere_mass(), 1e-18);
    EXPECT_EQ(stem.bond_outer_diameter, paper.bond_outer_diameter);
}

TEST(StemChain, HasTheFirstModeOfTheBeamUpToTheSquareOfTheBondLength) {
    const measure::Measurement measurement = tests::empty_measurement();
    const auto error = [&](int spheres) {
        run::CaseSpec spec = fit::chain_of(measurement, {spheres, {}}).spec;
        spec.stem.bond_damping = 1e-3;
        return run::first_mode(spec).natural_frequency() / physics::first_frequency(spec.stem) - 1;
    };
    // Shear and rotary inertia of the stem itself, (d/L)² and less, contribute some 1e-4 at any
    // bond length; the rest of the error falls with its square.
    const double coarse = error(15);
    const double medium = error(29);
    const double fine = error(57);
    EXPECT_LT(std::abs(fine), 4e-4);
    EXPECT_NEAR((coarse - medium) / (medium - fine), 4.0, 0.3); // next order: (l/L)⁴
}

TEST(StemChain, HasTheDampingRatioOfItsDampingTimeUnderBothLaws) {
    const measure::Measurement measurement = tests::empty_measurement();
    for (const auto& law : {physics::consistent_law(), physics::schramm2019_law()}) {
        run::CaseSpec spec = fit::chain_of(measurement, {56, law}).spec;
        spec.stem.bond_damping = 20.0;
        const integrate::VibrationMode mode = run::first_mode(spec);
        const double wanted = std::numbers::pi * mode.natural_frequency() * fit::damping_time(spec);
        // Dashpots also act on shear and rotary motion, which contributes some 1e-3.
        EXPECT_NEAR(mode.damping_ratio() / wanted, 1.0, 5e-3);
    }
}

TEST(StemChain, KeepsMeasurementAndDampingTimeWithOtherSpheres) {
    const measure::Measurement measurement = tests::empty_measurement();
    for (const physics::BondLawOptions& law :
         {physics::consistent_law(), physics::schramm2019_law()}) {
        run::CaseSpec fine = fit::chain_of(measurement, {56, law}).spec;
        fine.stem.bond_damping = 30.0;
        const run::CaseSpec changed = fit::with_spheres(fine, 20);
        const run::CaseSpec coarse = fit::chain_of(measurement, {20, law}).spec;
        EXPECT_EQ(changed.stem.sphere_count, 20);
        // Rounding only.
        EXPECT_NEAR(changed.stem.bond_length / coarse.stem.bond_length, 1.0, 1e-14);
        EXPECT_NEAR(changed.stem.density / coarse.stem.density, 1.0, 1e-14);
        EXPECT_NEAR(changed.stem.sphere_diameter / coarse.stem.sphere_diameter, 1.0, 1e-14);
        EXPECT_NEAR(fit::damping_time(changed) / fit::damping_time(fine), 1.0, 1e-14);
    }
}

TEST(StemChain, ReplacesASquareSectionByTheRingOfTheSameAreaAndSecondMoment) {
    measure::Measurement measurement = tests::empty_measurement();
    measurement.stem.section = measure::RectangularSection{3e-3, 3e-3};
    const fit::StemChain chain = fit::chain_of(measurement);
    EXPECT_NEAR(chain.spec.stem.section_area(), 9e-6, 1e-18); // rounding
    EXPECT_NEAR(chain.spec.stem.second_moment_of_area(), 81e-12 / 12, 1e-24);
    EXPECT_TRUE(chain.remarks.empty());
}

TEST(StemChain, KeepsTheSecondMomentOfAFlatSectionAndReportsTheLoss) {
    measure::Measurement measurement = tests::empty_measurement();
    measurement.stem.section = measure::RectangularSection{20e-3, 1e-3};
    const fit::StemChain chain = fit::chain_of(measurement);
    EXPECT_NEAR(chain.spec.stem.second_moment_of_area(), 20e-12 / 12, 1e-24); // rounding
    EXPECT_EQ(chain.remarks.size(), 1U);
}

/// Determinant of the free end's conditions of a clamped Timoshenko beam: d/ds of deflection,
/// rotation, moment and shear force is a constant matrix, whose exponential leads from end to end.
double timoshenko_determinant(const measure::MeasuredStem& stem, double youngs_modulus,
                              double correction, double angular_frequency) {
    const double area = measure::section_area(stem.section);
    const double second_moment = measure::second_moment_of_area(stem.section);
    const double shear_modulus = 0.5 * youngs_modulus / (1.0 + *stem.poissons_ratio);
    const double square = angular_frequency * angular_frequency;
    Eigen::Matrix4d rates = Eigen::Matrix4d::Zero(); // of (y, φ, M, Q)
    rates(0, 1) = 1.0;
    rates(0, 3) = 1.0 / (correction * shear_modulus * area);
    rates(1, 2) = 1.0 / (youngs_modulus * second_moment);
    rates(2, 3) = -1.0;
    rates(2, 1) = -stem.density * second_moment * square;
    rates(3, 0) = -stem.density * area * square;
    const Eigen::Matrix4d end = (rates * stem.length).exp();
    return end.block<2, 2>(2, 2).determinant(); // y = φ = 0 at the clamp, M = Q = 0 at the end
}

TEST(StemChain, HasTheFirstModeOfATimoshenkoBeamOfAThickSection) {
    measure::Measurement measurement = tests::empty_measurement();
    measure::MeasuredStem& stem = measurement.stem;
    stem.length = 0.1;
    stem.density = 1070.0;
    stem.poissons_ratio = 0.45;
    stem.section = measure::RectangularSection{0.03, 0.03};
    run::CaseSpec spec = fit::chain_of(measurement, {56, {}}).spec;
    spec.stem.bond_damping = 1e-3;
    const double found = 2.0 * std::numbers::pi * run::first_mode(spec).natural_frequency();
    // Cowper (1966), Journal of Applied Mechanics 33:335-340.
    const double correction = 10.0 * 1.45 / (12.0 + 11.0 * 0.45);
    double low = 0.9 * found;
    double high = 1.1 * found;
    const auto value = [&](double angular_frequency) {
        return timoshenko_determinant(stem, spec.stem.bond_youngs_modulus, correction,
                                      angular_frequency);
    };
    ASSERT_LT(value(low) * value(high), 0.0);
    for (int k = 0; k < 50; ++k) {
        const double middle = 0.5 * (low + high);
        (value(low) * value(middle) > 0.0 ? low : high) = middle;
    }
    EXPECT_NEAR(found / low, 1.0, 1e-3);
}

TEST(StemChain, FacesTheAirWithTheWidthOfARectangleAcrossTheMotion) {
    measure::Measurement measurement = tests::empty_measurement();
    EXPECT_EQ(fit::chain_of(measurement).spec.stem.width_in_air(),
              std::get<measure::CircularSection>(measurement.stem.section).diameter);
    for (const double depth : {1e-3, 3e-3, 20e-3}) {
        measurement.stem.section = measure::RectangularSection{6e-3, depth};
        run::CaseSpec spec = fit::chain_of(measurement).spec;
        spec.effects = {{physics::effect_named("quadratic_drag"), {1.5}}};
        const auto model = run::case_model(spec);
        // ½ ρ C_d w; rounding.
        EXPECT_NEAR(model.chain.air.at(0).coefficient, 0.5 * 1.2 * 1.5 * 6e-3, 1e-17) << depth;
    }
}

TEST(StemChain, RefusesAChainOfFourSpheres) {
    measure::Measurement measurement = tests::empty_measurement();
    EXPECT_THROW(static_cast<void>(fit::chain_of(measurement, {4, {}})), core::InputError);
}

} // namespace
