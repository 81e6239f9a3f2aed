// SPDX-License-Identifier: BSD-3-Clause
// The right-hand side for every scalar type, in two and three dimensions.
#include "core/lanes.hpp"
#include "integrate/bond_jacobian.hpp"
#include "physics/chain.hpp"
#include "support/random_chain_state.hpp"

#include <algorithm>
#include <cmath>

#include <ceres/jet.h>
#include <gtest/gtest.h>

namespace culm::physics {
namespace {

StemParameters<double> stem_number(int k) {
    StemParameters<double> stem;
    stem.sphere_count = 9;
    stem.bond_youngs_modulus = 1e9 * (1.0 + k);
    stem.bond_damping = 5.0 + 20.0 * k;
    stem.bond_inner_diameter = 1e-4 * k;
    stem.density = 125.0 + k;
    stem.axial_acceleration_of_gravity = -9.81;
    return stem;
}

double largest(const std::vector<double>& v) {
    double m = 0.0;
    for (const double x : v)
        m = std::max(m, std::abs(x));
    return m;
}

/// Largest number of each kind (position, velocity, spin, shear force, moment rates differ by ten
/// orders), so that each deviation is relative to its kind.
template <int Dim>
std::vector<double> kind_scales(const ChainLayout<Dim>& layout, const std::vector<double>& rate) {
    std::vector<double> scales(rate.size());
    const auto fill = [&](std::size_t first, std::size_t width, std::size_t stride,
                          std::size_t count) {
        double m = 0.0;
        for (std::size_t i = 0; i < count; ++i)
            for (std::size_t k = 0; k < width; ++k)
                m = std::max(m, std::abs(rate[first + i * stride + k]));
        for (std::size_t i = 0; i < count; ++i)
            for (std::size_t k = 0; k < width; ++k)
                scales[first + i * stride + k] = m;
    };
    const auto spheres = static_cast<std::size_t>(layout.sphere_count());
    const auto bonds = static_cast<std::size_t>(layout.bond_count());
    const std::size_t rotation = ChainLayout<Dim>::rotation;
    fill(0, Dim, ChainLayout<Dim>::sphere_size, spheres);
    fill(Dim, Dim, ChainLayout<Dim>::sphere_size, spheres);
    fill(2 * Dim, rotation, ChainLayout<Dim>::sphere_size, spheres);
    fill(layout.bond_offset(0), rotation, ChainLayout<Dim>::bond_size, bonds);
    fill(layout.bond_offset(0) + rotation, rotation, ChainLayout<Dim>::bond_size, bonds);
    fill(layout.geometry_offset(0), 1, ChainLayout<Dim>::geometry_size, bonds);
    fill(layout.geometry_offset(0) + 1, Dim, ChainLayout<Dim>::geometry_size, bonds);
    return scales;
}

template <class Dimension>
class RightHandSide : public testing::Test {};
using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(RightHandSide, Dimensions);

template <int Dim>
std::vector<double> rate_of(const Chain<Dim, double>& chain, const std::vector<double>& state) {
    std::vector<double> rate(state.size());
    chain.evaluate_rate(state.data(), rate.data());
    return rate;
}

TYPED_TEST(RightHandSide, EveryLaneAgreesWithTheDoubleEvaluation) {
    constexpr int Dim = TypeParam::value;
    using core::Lanes;
    for (const BondLawOptions& law : {schramm2019_law(), consistent_law()}) {
        StemParameters<Lanes> stems;
        stems.sphere_count = 9;
        const auto gather = [](double StemParameters<double>::*member) {
            return Lanes([&](auto lane) { return stem_number(static_cast<int>(lane)).*member; });
        };
        using Stem = StemParameters<double>;
        stems.bond_youngs_modulus = gather(&Stem::bond_youngs_modulus);
        stems.bond_damping = gather(&Stem::bond_damping);
        stems.bond_inner_diameter = gather(&Stem::bond_inner_diameter);
        stems.density = gather(&Stem::density);
        stems.axial_acceleration_of_gravity = gather(&Stem::axial_acceleration_of_gravity);
        const Chain<Dim, Lanes> lanes_chain(stems, law);

        std::vector<std::vector<double>> states;
        for (std::size_t lane = 0; lane < core::lane_count; ++lane) {
            const Chain<Dim, double> chain(stem_number(static_cast<int>(lane)), law);
            states.push_back(tests::random_state(chain, static_cast<unsigned>(lane)));
        }
        std::vector<Lanes> packed(states.front().size());
        for (std::size_t k = 0; k < packed.size(); ++k)
            packed[k] = Lanes([&](auto lane) { return states[lane][k]; });
        std::vector<Lanes> packed_rate(packed.size());
        lanes_chain.evaluate_rate(packed.data(), packed_rate.data());

        for (std::size_t lane = 0; lane < core::lane_count; ++lane) {
            const Chain<Dim, double> chain(stem_number(static_cast<int>(lane)), law);
            const auto rate = rate_of(chain, states[lane]);
            const auto scale = kind_scales(chain.layout(), rate);
            // Fused multiply-adds round differently in scalar and vector code; the differences of
            // some ten terms stay within some ten roundings of the largest term.
            for (std::size_t k = 0; k < rate.size(); ++k)
                EXPECT_NEAR(packed_rate[k][lane], rate[k], 1e-14 * scale[k]) << "number " << k;
        }
    }
}

TYPED_TEST(RightHandSide, DualNumbersCarryTheSameValueAndTheDirectionalDerivative) {
    constexpr int Dim = TypeParam::value;
    using Dual = ceres::Jet<double, 1>;
    for (const BondLawOptions& law : {schramm2019_law(), consistent_law()}) {
        const Chain<Dim, double> chain(stem_number(2), law);
        StemParameters<Dual> dual_stem;
        dual_stem.sphere_count = 9;
        dual_stem.bond_youngs_modulus = Dual(3e9);
        dual_stem.bond_damping = Dual(45.0);
        dual_stem.bond_inner_diameter = Dual(2e-4);
        dual_stem.density = Dual(127.0);
        dual_stem.axial_acceleration_of_gravity = Dual(-9.81);
        const Chain<Dim, Dual> dual_chain(dual_stem, law);

        const auto state = tests::random_state(chain, 7);
        const auto other = tests::random_state(chain, 8);
        std::vector<Dual> dual_state(state.size());
        for (std::size_t k = 0; k < state.size(); ++k) {
            dual_state[k].a = state[k];
            dual_state[k].v[0] = other[k] - state[k];
        }
        std::vector<Dual> dual_rate(state.size());
        dual_chain.evaluate_rate(dual_state.data(), dual_rate.data());

        const auto rate = rate_of(chain, state);
        const double step = 1e-5;
        std::vector<double> forward(state.size());
        std::vector<double> backward(state.size());
        std::vector<double> slope(state.size());
        for (std::size_t k = 0; k < state.size(); ++k) {
            forward[k] = state[k] + step * (other[k] - state[k]);
            backward[k] = state[k] - step * (other[k] - state[k]);
        }
        const auto ahead = rate_of(chain, forward);
        const auto behind = rate_of(chain, backward);
        for (std::size_t k = 0; k < state.size(); ++k)
            slope[k] = (ahead[k] - behind[k]) / (2 * step);
        const auto scale = kind_scales(chain.layout(), rate);
        const auto slope_scale = kind_scales(chain.layout(), slope);
        for (std::size_t k = 0; k < state.size(); ++k) {
            EXPECT_NEAR(dual_rate[k].a, rate[k], 1e-14 * scale[k]);
            // Central difference: truncation step² times a curvature of order one, rounding
            // 1e-16/step; both below 1e-9, on top of slopes that are large.
            EXPECT_NEAR(dual_rate[k].v[0], slope[k], 1e-8 * slope_scale[k]) << "number " << k;
        }
    }
}

TYPED_TEST(RightHandSide, BondJacobianEqualsCentralDifferences) {
    constexpr int Dim = TypeParam::value;
    using L = integrate::BondJacobianLayout<Dim>;
    const Chain<Dim, double> chain(stem_number(1), consistent_law());
    const auto state = tests::random_state(chain, 3);
    const auto& layout = chain.layout();
    const auto motion =
        chain.motion_between(layout.sphere(state.data(), 3), layout.sphere(state.data(), 4));
    const auto history = layout.bond(state.data(), 3);
    const auto geometry = layout.geometry(state.data(), 3);
    integrate::BondJacobian<Dim> jacobian;
    integrate::BondDifferentiator<Dim>(chain).evaluate(state.data(), 3, 0.0, jacobian);

    Eigen::Matrix<double, L::inputs, 1> inputs;
    inputs(L::length) = geometry.length;
    for (int d = 0; d < Dim; ++d) {
        inputs(L::direction + d) = geometry.direction[d];
        inputs(L::velocity + d) = motion.velocity[d];
    }
    for (int k = 0; k < L::rotation; ++k) {
        inputs(L::spin_1 + k) = motion.spin_1[k];
        inputs(L::spin_2 + k) = motion.spin_2[k];
        inputs(L::local + k) = history.shear_force[k];
        inputs(L::local + L::rotation + k) = history.moment[k];
    }
    const auto respond = [&](const Eigen::Matrix<double, L::inputs, 1>& x) {
        BondMotion<Dim, double> m;
        BondState<Dim, double> q;
        core::Vec<Dim, double> direction;
        std::copy_n(x.data() + L::direction, Dim, direction.component.begin());
        std::copy_n(x.data() + L::velocity, Dim, m.velocity.component.begin());
        std::copy_n(x.data() + L::spin_1, L::rotation, m.spin_1.component.begin());
        std::copy_n(x.data() + L::spin_2, L::rotation, m.spin_2.component.begin());
        std::copy_n(x.data() + L::local, L::rotation, q.shear_force.component.begin());
        std::copy_n(x.data() + L::local + L::rotation, L::rotation, q.moment.component.begin());
        const BondFrame<Dim, double> frame(x(L::length), direction);
        auto r = bond_response(chain.bond_coefficients(), chain.law(), frame, m, q);
        r.rate.shear_force += frame.shear_turning_rate(q.shear_force, m.velocity);
        r.rate.moment += frame.moment_turning_rate(q.moment, m.velocity);
        Eigen::Matrix<double, L::outputs, 1> out;
        std::copy_n(r.force.component.begin(), Dim, out.data());
        std::copy_n(r.torque_1.component.begin(), L::rotation, out.data() + L::torque_1);
        std::copy_n(r.torque_2.component.begin(), L::rotation, out.data() + L::torque_2);
        std::copy_n(r.rate.shear_force.component.begin(), L::rotation, out.data() + L::local_rate);
        std::copy_n(r.rate.moment.component.begin(), L::rotation,
                    out.data() + L::local_rate + L::rotation);
        const auto g = Chain<Dim, double>::geometry_rate(frame, m.velocity);
        out(L::local_rate + 2 * L::rotation) = g.length;
        std::copy_n(g.direction.component.begin(), Dim,
                    out.data() + L::local_rate + 2 * L::rotation + 1);
        return out;
    };
    for (int column = 0; column < L::inputs; ++column) {
        const double scale = std::max(std::abs(inputs(column)), column >= L::length ? 1e-3 : 1e-2);
        const double step = 1e-6 * scale;
        auto ahead = inputs;
        auto behind = inputs;
        ahead(column) += step;
        behind(column) -= step;
        const Eigen::Matrix<double, L::outputs, 1> up = respond(ahead);
        const Eigen::Matrix<double, L::outputs, 1> down = respond(behind);
        const Eigen::Matrix<double, L::outputs, 1> slope = (up - down) / (2 * step);
        for (int row = 0; row < L::outputs; ++row) {
            // Rounding of the outputs over the step dominates: 1e-16 · |output| / step, with room
            // for the cancellation among an output's terms.
            const double tolerance = 1e-7 * std::abs(slope(row)) + 1e-14 * std::abs(up(row)) / step;
            EXPECT_NEAR(jacobian(row, column), slope(row), tolerance) << row << ", " << column;
        }
    }
}

TEST(SpatialChain, MovesInATiltedPlaneAsThePlanarChainDoes) {
    const double angle = 0.7;
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    for (const BondLawOptions& law : {schramm2019_law(), consistent_law()}) {
        const Chain<2, double> planar(stem_number(1), law);
        const Chain<3, double> spatial(stem_number(1), law);
        const auto state = tests::random_state(planar, 11);
        auto tilted = spatial.straight_state();
        const auto lifted = [&](const core::Vec<2, double>& v) {
            return core::Vec<3, double>{{v[0], c * v[1], s * v[1]}};
        };
        const core::Vec<3, double> normal{{0.0, -s, c}};
        const auto& flat = planar.layout();
        const auto& space = spatial.layout();
        for (int i = 0; i < flat.sphere_count(); ++i) {
            const auto p = flat.sphere(state.data(), i);
            space.set_sphere(
                tilted.data(), i,
                SphereState<3, double>{lifted(p.position), lifted(p.velocity), p.spin[0] * normal});
        }
        for (int j = 0; j < flat.bond_count(); ++j) {
            const auto motion = planar.motion_between(flat.sphere(state.data(), j),
                                                      flat.sphere(state.data(), j + 1));
            const BondFrame<2, double> frame(motion.separation);
            const auto q = flat.bond(state.data(), j);
            space.set_bond(
                tilted.data(), j,
                BondState<3, double>{lifted(frame.to_world(q.shear_force)), q.moment[0] * normal});
        }
        space.set_geometry(tilted.data());
        const auto planar_rate = rate_of(planar, state);
        const auto spatial_rate = rate_of(spatial, tilted);
        const auto scale = kind_scales(flat, planar_rate);
        for (int i = 0; i < flat.sphere_count(); ++i) {
            const auto p = flat.sphere(planar_rate.data(), i);
            const auto q = space.sphere(spatial_rate.data(), i);
            const auto expected = lifted(p.velocity);
            for (int d = 0; d < 3; ++d) {
                // Rounding of the rotation and of the projections, some ten operations.
                EXPECT_NEAR(q.velocity[d], expected[d], 1e-13 * scale[flat.sphere_offset(i) + 2]);
                EXPECT_NEAR(q.spin[d], p.spin[0] * normal[d],
                            1e-13 * scale[flat.sphere_offset(i) + 4]);
            }
        }
    }
}

TEST(SpatialChain, TwistedStraightChainHasTheTorsionalStiffnessGIpOverLength) {
    StemParameters<double> stem;
    stem.sphere_count = 11;
    const Chain<3, double> chain(stem, consistent_law());
    const auto& layout = chain.layout();
    auto state = chain.straight_state();
    const double rate_of_twist = 0.3; // rad/s at the tip, linear along the stem
    for (int i = 1; i < 11; ++i) {
        auto sphere = layout.sphere(state.data(), i);
        sphere.spin[0] = rate_of_twist * i / 10.0;
        layout.set_sphere(state.data(), i, sphere);
    }
    const auto rate = rate_of(chain, state);
    const double shear_modulus = 1e9 / 2.6;
    const double polar_moment = 3.14159265358979323846 / 32 * std::pow(2.83e-3, 4);
    const double expected = shear_modulus * polar_moment / (10 * 2.83e-3) * rate_of_twist;
    for (int j = 0; j < layout.bond_count(); ++j) {
        const auto q = layout.bond(rate.data(), j);
        EXPECT_NEAR(q.moment[0], expected, 1e-13 * expected); // a few roundings
        EXPECT_EQ(q.moment[1], 0.0);
        EXPECT_EQ(q.shear_force[1], 0.0);
    }
}

TEST(Clamp, KeepsTheFirstSphereAtRestUnderGravityAndMotion) {
    const Chain<2, double> chain(stem_number(3), consistent_law());
    const auto rate = rate_of(chain, tests::random_state(chain, 5));
    for (std::size_t k = 0; k < ChainLayout<2>::sphere_size; ++k)
        EXPECT_EQ(rate[k], 0.0);
    EXPECT_GT(largest(rate), 0.0);
}

} // namespace
} // namespace culm::physics
