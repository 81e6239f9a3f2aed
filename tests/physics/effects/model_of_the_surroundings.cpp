// SPDX-License-Identifier: BSD-3-Clause
// Changes of the chain's coefficients by clamp, air, weight, release and camera.
#include "core/error.hpp"
#include "effect_bench.hpp"
#include "physics/effects/air.hpp"
#include "physics/energy.hpp"
#include "support/dissipated_power.hpp"
#include "support/random_chain_state.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace culm::physics {
namespace {

/// Sum of the forces on all spheres when they move sideways at `speed`, N.
double force_at(const EffectBench& bench, double speed) {
    const Chain<2, double> chain(bench.stem.sphere_count, bench.model, bench.law);
    SphereState<2, double> sphere{{{0.0, 0.0}}, {{0.0, speed}}, {{0.0}}};
    double sum = 0.0;
    for (int i = 0; i < bench.stem.sphere_count; ++i)
        sum += chain.node_load(i, sphere, {}, 0.0, true).force[1];
    return sum;
}

TEST(QuadraticDrag, IsHalfDensityTimesCoefficientWidthLengthAndSquaredSpeed) {
    const EffectBench bench({active("quadratic_drag", {1.3})});
    const double per_square = 0.5 * 1.2 * 1.3 * 2.83e-3 * (55.0 * 2.83e-3);
    expect_relative(force_at(bench, 2.0), -4.0 * per_square);
    expect_relative(force_at(bench, -3.0), 9.0 * per_square);
}

TEST(ViscousDrag, EqualsTheCoefficientTimesLengthAndSpeedWithQuadraticDrag) {
    const EffectBench viscous({active("viscous_drag", {2e-3})}, 21);
    expect_relative(force_at(viscous, 2.0), -2.0 * 2e-3 * viscous.stem.free_length());
    const EffectBench quadratic({active("quadratic_drag", {1.3})}, 21);
    const EffectBench both({active("viscous_drag", {2e-3}), active("quadratic_drag", {1.3})}, 21);
    expect_relative(force_at(both, 2.0), force_at(viscous, 2.0) + force_at(quadratic, 2.0));
}

TEST(PowerDrag, GrowsWithItsPowerOfTheSpeed) {
    for (const double exponent : {1.0, 1.3, 5.0 / 3.0, 2.0}) {
        const EffectBench bench({active("power_drag", {1.3, exponent})});
        const double at_one = 0.5 * 1.2 * 1.3 * 2.83e-3 * bench.stem.free_length();
        for (const double speed : {0.2, 1.0, 5.0}) {
            const double expected = at_one * std::pow(speed, exponent);
            // The smoothing at rest: (p - 1)/2 (1e-4 m/s over the speed)².
            EXPECT_NEAR(force_at(bench, speed), -expected, 2e-7 * expected) << exponent;
            EXPECT_NEAR(force_at(bench, -speed), expected, 2e-7 * expected) << exponent;
        }
    }
}

TEST(PowerDrag, ContainsViscousAndQuadraticDrag) {
    const EffectBench linear({active("power_drag", {1.3, 1.0})});
    const EffectBench viscous({active("viscous_drag", {0.5 * 1.2 * 1.3 * 2.83e-3})});
    const EffectBench square({active("power_drag", {1.3, 2.0})});
    const EffectBench quadratic({active("quadratic_drag", {1.3})});
    for (const double speed : {-2.0, 0.3, 4.0}) {
        expect_relative(force_at(linear, speed), force_at(viscous, speed));
        EXPECT_NEAR(force_at(square, speed) / force_at(quadratic, speed), 1.0, 1e-7);
    }
}

/// The derivative of the force, which the implicit integrator uses, stays finite and exact through
/// rest, where that of the bare power is infinite.
TEST(PowerDrag, HasAFiniteDerivativeAtRest) {
    const EffectBench bench({active("power_drag", {1.3, 1.2})});
    const Chain<2, double> chain(bench.stem.sphere_count, bench.model, bench.law);
    const auto load_at = [&](double along, double across) {
        const SphereState<2, double> sphere{{{0.0, 0.0}}, {{along, across}}, {{0.0}}};
        return chain.node_load(7, sphere, {}, 0.0, true);
    };
    for (const double speed : {0.0, 1e-5, 1e-4, 1e-2, 1.0}) {
        const double change = 1e-3 * std::max(speed, 1e-5);
        const auto load = load_at(0.5 * speed, speed);
        for (int k = 0; k < 2; ++k) {
            const double along = k == 0 ? change : 0.0;
            const double across = k == 1 ? change : 0.0;
            const auto above = load_at(0.5 * speed + along, speed + across);
            const auto below = load_at(0.5 * speed - along, speed - across);
            const auto& slope = load.by_velocity[static_cast<std::size_t>(k)];
            const double size = std::abs(load.by_velocity[1][1]);
            ASSERT_GT(size, 0.0);
            // The error of the central difference is (1e-3)².
            for (int d = 0; d < 2; ++d)
                EXPECT_NEAR(slope[d], (above.force[d] - below.force[d]) / (2.0 * change),
                            1e-5 * size)
                    << speed;
        }
    }
}

TEST(PlateAir, IsRefusedForARoundStem) {
    EXPECT_THROW(EffectBench({active("plate_air", {8.0, 0.35})}), core::InputError);
}

TEST(StillAir, IsStokesFunction) {
    // Sader (1998) prints no table. At high Reynolds numbers Stokes' boundary layer of the
    // thickness δ = √(2ν/ω) = W √(1/2Re) on a cylinder gives Γ = 1 + 2δ/R + 2i δ/R, R = W/2, up to
    // (δ/R)²; at low ones |Γ| is dominated by the loss.
    for (const double reynolds_number : {1e3, 1e4}) {
        const double layer = std::sqrt(2.0 / reynolds_number); // δ/R with Re = ωR²/ν
        const auto function = hydrodynamic_function(reynolds_number, false);
        EXPECT_NEAR(function.real(), 1.0 + 2.0 * layer, layer * layer);
        EXPECT_NEAR(function.imag(), 2.0 * layer, layer * layer);
    }
    // Of z = 1, from tables of K_0 and K_1 (Abramowitz & Stegun 9.8) at complex argument there is
    // none; the differential equation holds: with f = K_1/K_0, f' = f² − f/z − 1.
    const auto ratio = [](std::complex<double> z) {
        const double reynolds_number = std::norm(z);
        const std::complex<double> root = std::sqrt(std::complex<double>(0.0, reynolds_number));
        return (hydrodynamic_function(reynolds_number, false) - 1.0) * root /
               std::complex<double>(0.0, 4.0);
    };
    const std::complex<double> direction = std::polar(1.0, -0.25 * std::numbers::pi);
    for (const double size : {0.01, 0.3, 1.0, 5.0, 60.0}) {
        const double step = 1e-4 * size;
        const std::complex<double> z = size * direction;
        const auto slope = (ratio((size + step) * direction) - ratio((size - step) * direction)) /
                           (2.0 * step * direction);
        const auto f = ratio(z);
        EXPECT_LT(std::abs(slope - (f * f - f / z - 1.0)), 1e-6 * std::abs(f / z)) << size;
    }
    // A plate has the same added mass as a cylinder where the boundary layer is thin.
    EXPECT_NEAR(hydrodynamic_function(1e4, true).real(), 1.0, 0.05);
}

TEST(Gravity, ActsAlongAndAcross) {
    const EffectBench bench({active("gravity", {-9.0, 3.0})});
    EXPECT_EQ(bench.model.gravity[0], -9.0);
    EXPECT_EQ(bench.model.gravity[1], 3.0);
    EXPECT_EQ(bench.model.gravity[2], 0.0);
}

TEST(Gravity, IsNotGivenTwice) {
    EffectBench bench({});
    bench.stem.axial_acceleration_of_gravity = -9.81;
    EffectTarget target{bench.stem, bench.law, bench.model, bench.camera};
    EXPECT_THROW(apply_effects(std::vector{active("gravity", {-9.81, 0.0})}, target),
                 core::InputError);
}

TEST(TipMass, IsTheLastSpheresAndLeavesTheDamping) {
    const EffectBench bench({active("tip_mass", {5e-6})});
    expect_relative(bench.model.spheres.back().mass, bench.stem.sphere_mass() + 5e-6);
    expect_relative(bench.mass(), 56.0 * bench.stem.sphere_mass() + 5e-6);
    EXPECT_EQ(bench.model.bonds.back().shear_damping, bench.plain_bond().shear_damping);
    EXPECT_EQ(bench.model.spheres.back().moment, bench.stem.sphere_inertia());
}

TEST(Clamp, YieldsWithAndWithoutFriction) {
    const EffectBench compliant({active("clamp_compliance", {0.7, 0.0})});
    ASSERT_TRUE(compliant.model.hinge);
    EXPECT_EQ(compliant.model.hinge->stiffness, 0.7);
    EXPECT_EQ(compliant.model.hinge->friction_moment, 0.0);
    EXPECT_GT(compliant.model.hinge->friction_rate, 0.0); // it is a divisor
    const EffectBench rubbing({active("clamp_friction", {3e-4, 0.8, 0.05})});
    ASSERT_TRUE(rubbing.model.hinge);
    EXPECT_EQ(rubbing.model.hinge->stiffness, 0.8);
    EXPECT_EQ(rubbing.model.hinge->friction_moment, 3e-4);
    EXPECT_EQ(rubbing.model.hinge->friction_rate, 0.05);
}

TEST(BaseMotion, HasAnAngularFrequency) {
    const EffectBench bench({active("base_motion", {1e-4, 50.0, 0.3})});
    ASSERT_TRUE(bench.model.base_motion);
    EXPECT_EQ(bench.model.base_motion->amplitude, 1e-4);
    expect_relative(bench.model.base_motion->angular_frequency, 100.0 * std::numbers::pi);
    EXPECT_EQ(bench.model.base_motion->phase, 0.3);
}

TEST(FiniteRelease, LastsAsLongAsItSays) {
    const EffectBench bench({active("finite_release", {3e-3})});
    ASSERT_TRUE(bench.model.release);
    EXPECT_EQ(bench.model.release->duration, 3e-3);
}

TEST(Camera, LeavesTheStemAlone) {
    const EffectBench bench({active("rolling_shutter", {2e-4}), active("camera_tilt", {-0.03})});
    EXPECT_EQ(bench.camera, (CameraView{2e-4, -0.03}));
    EXPECT_TRUE(bench.model.is_plain());
}

/// A chain in an arbitrary motion, including that of a compliant clamp.
struct MovingChain {
    Chain<2, double> chain;
    std::vector<double> state;

    explicit MovingChain(const EffectBench& bench)
        : chain(bench.stem.sphere_count, bench.model, bench.law),
          state(tests::random_state(chain, 5)) {
        auto base = chain.layout().sphere(state.data(), 0);
        base.spin[0] = 0.07;
        chain.layout().set_sphere(state.data(), 0, base);
    }
    [[nodiscard]] double power() const { return tests::dissipated_power(chain, state.data()); }
};

TEST(AirDrag, DissipatesThePowerThatItsCardStates) {
    const EffectBench bare({});
    const EffectBench quadratic({active("quadratic_drag", {1e5})});
    const EffectBench viscous({active("viscous_drag", {1e3})});
    const EffectBench powered({active("power_drag", {1e5, 1.5})});
    const MovingChain moving(bare);
    double by_power = 0.0;
    double by_cube = 0.0;
    double by_square = 0.0;
    for (int i = 0; i < bare.stem.sphere_count; ++i) {
        const auto velocity = moving.chain.layout().sphere(moving.state.data(), i).velocity;
        const bool is_end = i == 0 || i + 1 == bare.stem.sphere_count;
        const double length = (is_end ? 0.5 : 1.0) * bare.stem.bond_length;
        by_cube += 0.5 * 1.2 * 1e5 * bare.stem.bond_outer_diameter * length *
                   std::pow(dot(velocity, velocity), 1.5);
        by_power += 0.5 * 1.2 * 1e5 * bare.stem.bond_outer_diameter * length *
                    std::pow(dot(velocity, velocity), 1.25);
        by_square += 1e3 * length * dot(velocity, velocity);
    }
    // Rounding of the difference of two powers, of which the bonds' is larger.
    const double bonds = moving.power();
    EXPECT_NEAR(MovingChain(quadratic).power() - bonds, by_cube, 1e-12 * bonds);
    EXPECT_NEAR(MovingChain(viscous).power() - bonds, by_square, 1e-12 * bonds);
    // The smoothing at rest: a quarter of (1e-4 m/s over the speeds, which are near 1 m/s)².
    EXPECT_NEAR(MovingChain(powered).power() - bonds, by_power, 1e-7 * by_power + 1e-12 * bonds);
    EXPECT_GT(by_power, 1e-6 * bonds);
    EXPECT_GT(by_cube, 1e-6 * bonds);
    EXPECT_GT(by_square, 1e-6 * bonds);
}

TEST(Clamp, DissipatesThePowerThatItsCardStates) {
    const MovingChain smooth(EffectBench({active("clamp_friction", {0.0, 0.8, 0.05})}));
    const MovingChain rubbing(EffectBench({active("clamp_friction", {1e3, 0.8, 0.05})}));
    const double expected = 1e3 * 0.07 * std::tanh(0.07 / 0.05);
    EXPECT_NEAR(rubbing.power() - smooth.power(), expected, 1e-12 * smooth.power());
    EXPECT_GT(expected, 1e-9 * smooth.power());
}

} // namespace
} // namespace culm::physics
