// SPDX-License-Identifier: BSD-3-Clause
// The explicit integrator: its order with damping, its stability limit, lanes, and agreement with
// the implicit one.
#include "integrate/velocity_verlet.hpp"

#include "core/lanes.hpp"
#include "integrate/history_sampler.hpp"
#include "integrate/implicit.hpp"
#include "integrate/statics.hpp"
#include "physics/energy.hpp"
#include "support/integrate_implicit.hpp"
#include "support/modal_state.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace culm::integrate {
namespace {

physics::StemParameters<double> small_stem(double damping) {
    physics::StemParameters<double> stem;
    stem.sphere_count = 12;
    stem.bond_damping = damping;
    return stem;
}

template <class Dimension>
class ExplicitOrder : public testing::Test {};
using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(ExplicitOrder, Dimensions);

/// Observed order of the tip's position from three halvings of a step at 0.4 of the limit:
/// differences of successive refinements fall by the factor 2^order.
template <int Dim>
double observed_order(double damping) {
    const auto stem = small_stem(damping);
    const physics::Chain<Dim, double> chain(stem, physics::schramm2019_law());
    const auto mode =
        tests::first_mode_state(physics::Chain<2, double>(stem, physics::schramm2019_law()),
                                linearise_transverse(stem, physics::schramm2019_law()), 1e-6);
    std::vector<double> start = chain.straight_state();
    for (int i = 0; i < 12; ++i) {
        const auto flat = physics::ChainLayout<2>(12).sphere(mode.state.data(), i);
        auto sphere = chain.layout().sphere(start.data(), i);
        for (int d = 0; d < 2; ++d) {
            sphere.position[d] = flat.position[d];
            sphere.velocity[d] = flat.velocity[d];
        }
        sphere.spin[physics::rotation_dimension<Dim> - 1] = flat.spin[0];
        chain.layout().set_sphere(start.data(), i, sphere);
    }
    for (int j = 0; j < 11; ++j) {
        const auto flat = physics::ChainLayout<2>(12).bond(mode.state.data(), j);
        auto bond = chain.layout().bond(start.data(), j);
        bond.shear_force[Dim == 2 ? 0 : 1] = flat.shear_force[0];
        bond.moment[physics::rotation_dimension<Dim> - 1] = flat.moment[0];
        chain.layout().set_bond(start.data(), j, bond);
    }
    const double step = 0.4 * std::min(largest_stable_step(linearise_transverse(stem, chain.law())),
                                       largest_stable_step(linearise_axial(stem, chain.law())));
    std::vector<double> tips;
    for (int refinement = 1; refinement <= 4; refinement *= 2) {
        VelocityVerlet<Dim, double> verlet(chain, start, step / refinement);
        verlet.advance(2000 * refinement);
        tips.push_back(verlet.position(11)[1]);
    }
    return std::log2(std::abs((tips[0] - tips[1]) / (tips[1] - tips[2])));
}

TYPED_TEST(ExplicitOrder, IsTwoWithoutDamping) {
    // The initial half step of the histories is not centred. Its first-order error, (hω)·1e-3 in
    // relative terms, is below the second-order one at these steps.
    EXPECT_NEAR(observed_order<TypeParam::value>(1e-9), 2.0, 0.15);
}

TYPED_TEST(ExplicitOrder, IsOneWithDampingAsTheModifiedEquationPredicts) {
    // Forces from half-step velocities give (λ−1)² + hc(λ−1) + h²ω²λ = 0 for a mode, that is
    // s²(1 − hc/2) + cs + ω² = O(h²): the error is of first order in h, with the small factor c.
    EXPECT_NEAR(observed_order<TypeParam::value>(5.0), 1.0, 0.1);
}

TEST(ExplicitDamping, FirstOrderErrorHasTheSizeOfTheModifiedEquation) {
    const auto stem = small_stem(25.0);
    const auto law = physics::schramm2019_law();
    const physics::Chain<2, double> chain(stem, law);
    const auto mode = tests::first_mode_state(chain, linearise_transverse(stem, law), 1e-6);
    const double step = 0.5 * std::min(largest_stable_step(linearise_transverse(stem, law)),
                                       largest_stable_step(linearise_axial(stem, law)));
    // c and ω² of the mode from its eigenvalue, then the root of the modified quadratic.
    const double c = -2 * mode.eigenvalue.real();
    const double omega_squared = std::norm(mode.eigenvalue);
    const double mass = 1 - step * c / 2;
    const std::complex<double> modified =
        (-c + std::sqrt(std::complex<double>(c * c - 4 * mass * omega_squared))) / (2 * mass);
    const std::int64_t steps = 40000;
    VelocityVerlet<2, double> verlet(chain, mode.state, step);
    verlet.advance(steps);
    const double time = step * static_cast<double>(steps);
    const double tip = verlet.position(11)[1] / 1e-6;
    const double exact = std::exp(mode.eigenvalue * time).real();
    const double predicted = std::exp(modified * time).real();
    ASSERT_GT(std::abs(predicted - exact), 1e-7);
    // The mode shapes of the discrete map also differ at first order, which the scalar equation
    // neglects. Therefore only the magnitudes must agree.
    EXPECT_LT(std::abs(tip - exact), 5 * std::abs(predicted - exact));
    EXPECT_LT(std::abs(tip - exact), 1e-4) << "negligible relative to the camera's noise";
}

TEST(ExplicitStability, EndsAtTheLimitOfTheLinearisedChainForBothLaws) {
    for (const auto& law : {physics::schramm2019_law(), physics::consistent_law()})
        for (const double damping : {1.0, 25.0}) {
            const auto stem = small_stem(damping);
            const physics::Chain<2, double> chain(stem, law);
            const double limit = std::min(largest_stable_step(linearise_transverse(stem, law)),
                                          largest_stable_step(linearise_axial(stem, law)));
            const auto released = deflected_equilibrium(chain, 0.1e-3).state;
            const double initial = physics::stored_energy(chain, released.data());
            const auto energy_after = [&](double step) {
                VelocityVerlet<2, double> verlet(chain, released, step);
                verlet.advance(20000);
                return physics::stored_energy(chain, verlet.state().data());
            };
            // Above the limit rounding errors grow by about 1 % per step. Deflections may stay
            // bounded, since an unstable axial mode saturates in a crumpled chain; therefore the
            // test uses the energy.
            EXPECT_LT(energy_after(0.99 * limit), initial);
            EXPECT_FALSE(energy_after(1.01 * limit) < initial);
        }
}

TEST(ExplicitLanes, ComputeTheSameMotionAsScalars) {
    using core::Lanes;
    physics::StemParameters<Lanes> stems;
    stems.sphere_count = 12;
    stems.bond_damping = Lanes([](auto lane) { return 2.0 + double(lane); });
    stems.bond_youngs_modulus = Lanes([](auto lane) { return 1e9 + 1e8 * double(lane); });
    const physics::Chain<2, Lanes> chain(stems, physics::consistent_law());

    const double step = 1e-8;
    std::vector<std::vector<double>> released;
    std::vector<double> tips;
    for (std::size_t lane = 0; lane < core::lane_count; ++lane) {
        auto stem = small_stem(2.0 + static_cast<double>(lane));
        stem.bond_youngs_modulus = 1e9 + 1e8 * static_cast<double>(lane);
        const physics::Chain<2, double> one(stem, physics::consistent_law());
        released.push_back(deflected_equilibrium(one, 4e-3).state);
        VelocityVerlet<2, double> verlet(one, released.back(), step);
        verlet.advance(20000);
        tips.push_back(verlet.position(11)[1]);
    }
    std::vector<Lanes> packed(released.front().size());
    for (std::size_t k = 0; k < packed.size(); ++k)
        packed[k] = Lanes([&](auto lane) { return released[lane][k]; });
    VelocityVerlet<2, Lanes> verlet(chain, packed, step);
    verlet.advance(20000);
    for (std::size_t lane = 0; lane < core::lane_count; ++lane)
        // Fused multiply-adds round differently; 20000 stable steps do not amplify that.
        EXPECT_NEAR(verlet.position(11)[1][lane], tips[lane], 1e-12 * 4e-3);
}

TEST(ExplicitAndImplicit, GiveTheSameReleasedMotion) {
    for (const auto& law : {physics::schramm2019_law(), physics::consistent_law()}) {
        const auto stem = small_stem(5.0);
        const physics::Chain<2, double> chain(stem, law);
        const auto released = deflected_equilibrium(chain, 4e-3).state;
        const double step = 2e-9;
        const std::int64_t count = 1'000'000; // 2 ms: two and a half cycles of this short stem
        VelocityVerlet<2, double> verlet(chain, released, step);
        verlet.advance(count);

        ImplicitOptions options;
        options.relative_tolerance = 1e-8;
        auto state = released;
        double implicit_tip = 0.0;
        HistorySampler<2> sampler(
            chain.layout(), 11, 11, 2e-3, 2, false,
            [&](std::size_t, const auto& rates) { implicit_tip = rates[0][1]; });
        integrate_implicit(
            chain, state, cantilever_scales(stem, 4e-3), 2e-3,
            [&](double t, std::span<const double> at) { sampler.observe(t, at); }, options);
        sampler.finish();
        // Verlet's own first-order error hc/2 is 1e-6 here; the implicit tolerance adds up to
        // about the same over some hundred steps.
        EXPECT_NEAR(verlet.position(11)[1], implicit_tip, 5e-6 * 4e-3);
    }
}

TEST(VelocityVerlet, ReportsVelocitiesAtTheTimeOfThePositions) {
    const auto stem = small_stem(5.0);
    const auto law = physics::schramm2019_law();
    const physics::Chain<2, double> chain(stem, law);
    const auto mode = tests::first_mode_state(chain, linearise_transverse(stem, law), 1e-6);
    const double step = 1e-8;
    VelocityVerlet<2, double> verlet(chain, mode.state, step);
    verlet.advance(10000);
    const auto tip = chain.layout().sphere(verlet.state().data(), 11);
    const auto exact = mode.eigenvalue * 1e-6 * std::exp(mode.eigenvalue * (10000 * step));
    // An error of half a step would be ω² h/2 relative to ω: 2e-5 at this frequency.
    EXPECT_NEAR(tip.velocity[1] / exact.real(), 1.0, 5e-6);
}

} // namespace
} // namespace culm::integrate
