// SPDX-License-Identifier: BSD-3-Clause
// Quantities that the force law conserves, and those that the authors' law does not.
#include "physics/energy.hpp"
#include "support/dissipated_power.hpp"
#include "support/random_chain_state.hpp"

#include <cmath>

#include <ceres/jet.h>
#include <gtest/gtest.h>

namespace culm::physics {
namespace {

template <class T>
StemParameters<T> short_stem() {
    StemParameters<T> stem;
    stem.sphere_count = 8;
    stem.bond_youngs_modulus = T(2e9);
    stem.bond_damping = T(3.0);
    return stem;
}

template <class Dimension>
class Conservation : public testing::Test {};
using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(Conservation, Dimensions);

TYPED_TEST(Conservation, StoredEnergyFallsByTheDissipatedPower) {
    constexpr int Dim = TypeParam::value;
    using Dual = ceres::Jet<double, 1>;
    for (const BondLawOptions& law : {schramm2019_law(), consistent_law()})
        for (unsigned seed = 1; seed <= 5; ++seed) {
            StemParameters<double> stem = short_stem<double>();
            StemParameters<Dual> dual_stem = short_stem<Dual>();
            stem.axial_acceleration_of_gravity = -9.81;
            dual_stem.axial_acceleration_of_gravity = Dual(-9.81);
            const Chain<Dim, double> chain(stem, law);
            const Chain<Dim, Dual> dual_chain(dual_stem, law);
            const auto state = tests::random_state(chain, seed);
            std::vector<double> rate(state.size());
            chain.evaluate_rate(state.data(), rate.data());
            // d(energy)/dt is the derivative of the energy along the rate: exact by dual numbers.
            std::vector<Dual> moving(state.size());
            for (std::size_t k = 0; k < state.size(); ++k) {
                moving[k].a = state[k];
                moving[k].v[0] = rate[k];
            }
            const double change = stored_energy(dual_chain, moving.data()).v[0];
            const double power = tests::dissipated_power(chain, state.data());
            // Kinetic and elastic power cancel to the dissipated one; the cancelling terms are up
            // to 1e4 times larger in these stirred states.
            EXPECT_NEAR(change, -power, 1e-10 * std::abs(power)) << "seed " << seed;
            EXPECT_GT(std::abs(power), 0.0);
        }
}

TYPED_TEST(Conservation, FreeChainKeepsItsLinearMomentum) {
    constexpr int Dim = TypeParam::value;
    for (const BondLawOptions& law : {schramm2019_law(), consistent_law()}) {
        const Chain<Dim, double> chain(short_stem<double>(), law, Support::Free);
        const auto state = tests::random_state(chain, 4);
        std::vector<double> rate(state.size());
        chain.evaluate_rate(state.data(), rate.data());
        double largest_force = 0.0;
        Vec<Dim, double> sum = Vec<Dim, double>::zero();
        for (int i = 0; i < 8; ++i) {
            const auto sphere = chain.layout().sphere(rate.data(), i);
            sum += chain.sphere_inertia().mass * sphere.velocity;
            for (int d = 0; d < Dim; ++d)
                largest_force = std::max(
                    largest_force, std::abs(chain.sphere_inertia().mass * sphere.velocity[d]));
        }
        for (int d = 0; d < Dim; ++d)
            EXPECT_NEAR(sum[d], 0.0, 1e-14 * largest_force); // rounding of eight terms
    }
}

/// Rate of change of the angular momentum of a free chain, N m, and the size of its terms.
template <int Dim>
struct AngularMomentumRate {
    Rotational<Dim, double> total = Rotational<Dim, double>::zero();
    double scale = 0.0;
};

template <int Dim>
AngularMomentumRate<Dim> angular_momentum_rate(const Chain<Dim, double>& chain,
                                               const std::vector<double>& state) {
    std::vector<double> rate(state.size());
    chain.evaluate_rate(state.data(), rate.data());
    AngularMomentumRate<Dim> result;
    const auto& inertia = chain.sphere_inertia();
    for (int i = 0; i < chain.layout().sphere_count(); ++i) {
        const auto at = chain.layout().sphere(state.data(), i);
        const auto change = chain.layout().sphere(rate.data(), i);
        Rotational<Dim, double> orbital;
        if constexpr (Dim == 2)
            orbital[0] = inertia.mass * cross(at.position, change.velocity);
        else
            orbital = inertia.mass * cross(at.position, change.velocity);
        result.total += orbital + inertia.moment * change.spin;
        result.scale = std::max(result.scale, std::sqrt(dot(orbital, orbital)));
    }
    return result;
}

TYPED_TEST(Conservation, ConsistentLawKeepsTheAngularMomentumOfAFreeChain) {
    constexpr int Dim = TypeParam::value;
    const Chain<Dim, double> chain(short_stem<double>(), consistent_law(), Support::Free);
    for (unsigned seed = 1; seed <= 5; ++seed) {
        const auto rate = angular_momentum_rate(chain, tests::random_state(chain, seed));
        for (const double component : rate.total.component)
            EXPECT_NEAR(component, 0.0, 1e-13 * rate.scale); // rounding of sixteen terms
    }
}

TYPED_TEST(Conservation, AuthorsLawLosesTheTorqueOfTheShearDamping) {
    constexpr int Dim = TypeParam::value;
    const Chain<Dim, double> chain(short_stem<double>(), schramm2019_law(), Support::Free);
    const auto& layout = chain.layout();
    const auto& bond = chain.bond_coefficients();
    const auto state = tests::random_state(chain, 6);
    const auto rate = angular_momentum_rate(chain, state);
    // The forces on the two spheres form a couple with the arm r; the torques balance only that
    // of the elastic shear force with the arm 2R. The remaining torque per bond is
    // −r n×(F + D) + 2R n×F.
    Rotational<Dim, double> expected = Rotational<Dim, double>::zero();
    for (int j = 0; j < layout.bond_count(); ++j) {
        const auto motion = chain.motion_between(layout.sphere(state.data(), j),
                                                 layout.sphere(state.data(), j + 1));
        const BondFrame<Dim, double> frame(motion.separation);
        const auto elastic = layout.bond(state.data(), j).shear_force;
        const auto damping =
            bond.shear_damping *
            shear_velocity(frame, motion, lever_arms(bond, chain.law(), frame.length()));
        expected += bond.span * frame.moment_of(elastic) -
                    frame.length() * frame.moment_of(elastic + damping);
    }
    double size = 0.0;
    for (int k = 0; k < rotation_dimension<Dim>; ++k) {
        EXPECT_NEAR(rate.total[k], expected[k], 1e-13 * rate.scale);
        size = std::max(size, std::abs(expected[k]));
    }
    EXPECT_GT(size, 1e-3 * rate.scale) << "the state does not exercise the missing torque";
}

} // namespace
} // namespace culm::physics
