// SPDX-License-Identifier: BSD-3-Clause
// The condensed Newton system against a dense solve with a finite-difference Jacobian.
#include "integrate/condensed_newton.hpp"

#include "support/random_chain_state.hpp"

#include <cmath>

#include <Eigen/LU>
#include <gtest/gtest.h>

namespace culm::integrate {
namespace {

template <class Dimension>
class CondensedNewtonTest : public testing::Test {};
using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(CondensedNewtonTest, Dimensions);

/// J v by a central difference of the right-hand side along v.
template <int Dim>
std::vector<double> jacobian_times(const physics::Chain<Dim, double>& chain,
                                   const std::vector<double>& state, const std::vector<double>& v,
                                   double step) {
    std::vector<double> ahead(state.size());
    std::vector<double> behind(state.size());
    std::vector<double> moved = state;
    for (std::size_t k = 0; k < state.size(); ++k)
        moved[k] = state[k] + step * v[k];
    chain.evaluate_rate(moved.data(), ahead.data());
    for (std::size_t k = 0; k < state.size(); ++k)
        moved[k] = state[k] - step * v[k];
    chain.evaluate_rate(moved.data(), behind.data());
    for (std::size_t k = 0; k < state.size(); ++k)
        ahead[k] = (ahead[k] - behind[k]) / (2 * step);
    return ahead;
}

/// Solves (I − γJ) x = b with b made from a known x and a finite-difference J.
template <int Dim>
void expect_solution(const physics::Chain<Dim, double>& chain, double gamma) {
    auto state = tests::random_state(chain, 21);
    const auto wanted = tests::random_state(chain, 22);
    const auto straight = chain.straight_state();
    const auto& layout = chain.layout();
    if (layout.base_slips()) { // a clamp that turns while its moment grows
        state[layout.base_moment_offset()] = 0.05;
        state[layout.sphere_offset(0) + 2 * Dim + physics::bending_axis<Dim>] = 0.7;
    }
    std::vector<double> x(state.size());
    for (std::size_t k = 0; k < x.size(); ++k)
        x[k] = 1e-3 * (wanted[k] - straight[k]);
    // Branch moments and the clamp's rotation, of the size that the motion gives them.
    for (std::size_t k = layout.branch_offset(0); k < x.size(); ++k)
        x[k] = 1e-6 * static_cast<double>(1 + k % 3);
    if (layout.base_turns())
        x[layout.sphere_offset(0) + 2 * Dim + physics::bending_axis<Dim>] = 0.2;
    // b = (I − γJ) x, so that the solve must return x.
    const auto jx = jacobian_times(chain, state, x, 1e-3);
    std::vector<double> b(x.size());
    for (std::size_t k = 0; k < x.size(); ++k)
        b[k] = x[k] - gamma * jx[k];

    CondensedNewton<Dim> newton(chain);
    newton.set_state(state.data());
    ASSERT_TRUE(newton.factorise(gamma));
    std::vector<double> solved(x.size());
    newton.solve(b.data(), solved.data());
    // The solution may be ill-conditioned, so the test checks that the residual is small relative
    // to b. The difference quotient has an error of about 1e-8.
    const auto jsolved = jacobian_times(chain, state, solved, 1e-3);
    double worst = 0.0;
    double size = 0.0;
    const auto compare = [&](std::size_t at) {
        const double scale = std::abs(b[at]) + std::abs(gamma * jx[at]) + 1e-12;
        worst = std::max(worst, std::abs(solved[at] - gamma * jsolved[at] - b[at]) / scale);
        size = std::max(size, std::abs(solved[at] - x[at]) / (std::abs(x[at]) + 1e-9));
    };
    for (int i = 0; i < layout.sphere_count(); ++i)
        for (std::size_t k = 0; k < physics::ChainLayout<Dim>::sphere_size; ++k)
            compare(layout.sphere_offset(i) + k);
    for (std::size_t k = layout.branch_offset(0); k < x.size(); ++k)
        compare(k);
    EXPECT_LT(worst, 1e-4) << "gamma " << gamma;
    EXPECT_LT(size, 1e-2) << "gamma " << gamma;
}

physics::StemParameters<double> short_stem() {
    physics::StemParameters<double> stem;
    stem.sphere_count = 7;
    stem.bond_damping = 30.0;
    return stem;
}

TYPED_TEST(CondensedNewtonTest, SolvesTheFullSystem) {
    constexpr int Dim = TypeParam::value;
    for (const auto support : {physics::Support::Clamped, physics::Support::Free})
        for (const double gamma : {1e-8, 1e-6, 1e-4})
            expect_solution(
                physics::Chain<Dim, double>(short_stem(), physics::consistent_law(), support),
                gamma);
}

/// r = c (1 + a v³), with v the speed.
struct SteepResistance {
    template <class T>
    static physics::Resistance<T> at(const T& coefficient, const T& speed,
                                     std::span<const T> shape) {
        const T cubic = coefficient * shape[0];
        return {coefficient + cubic * speed * speed * speed, T(3.0) * cubic * speed * speed};
    }
};

/// Every part that an effect may add, each with a significant value.
physics::ChainModel<double> model_with_everything() {
    const auto stem = short_stem();
    auto model = physics::plain_chain(stem, physics::consistent_law());
    model.bonds.resize(6, model.bonds.front());
    model.spheres.resize(7, model.spheres.front());
    for (std::size_t j = 0; j < model.bonds.size(); ++j)
        model.bonds[j].bending_stiffness *= 1.0 + 0.1 * static_cast<double>(j);
    model.spheres.back().mass *= 3.0;
    model.hinge = physics::BaseHinge<double>{0.5, 1e-3, 100.0, 1e-4};
    model.slip = physics::JointSlip<double>{20.0, 1.3};
    model.air_mass = physics::AirMass<double>{1e-3, 2e-3, 1e-3};
    model.branches = {{0.3, 1e-4, 1.0}, {0.2, 1e-2, 0.0}};
    model.air = {{&physics::resistance_law<SteepResistance>, 1e-2, {0.7}}};
    model.bending = physics::BendingLaw<double>{-1e-3, 0.2, 0.5};
    model.bending_loss = physics::BendingLoss<double>{1e-3, 1.4, 0.5};
    // Each law uses the inputs that its Jacobian covers: deflection and velocity for a force and
    // the clamp, curvature for a bond.
    const auto on_motion = [](const physics::UserLawInputs& in, std::span<const double> p) {
        return -p[0] * (in.velocity * std::abs(in.velocity) + 300.0 * in.deflection);
    };
    const auto on_curvature = [](const physics::UserLawInputs& in, std::span<const double> p) {
        return p[0] * (in.curvature * std::abs(in.curvature) + 1e-3 * in.curvature_rate);
    };
    const auto law = [](physics::UserLawKind kind, const physics::UserExpression& expression,
                        double parameter) {
        return physics::UserLaw<double>{
            kind, std::make_shared<const physics::UserExpression>(expression), {parameter}};
    };
    using physics::UserLawKind;
    model.user_laws = {law(UserLawKind::ForcePerLength, on_motion, 0.7),
                       law(UserLawKind::BendingMoment, on_curvature, 1e-2),
                       law(UserLawKind::BaseMoment, on_motion, 1e-6)};
    return model;
}

TYPED_TEST(CondensedNewtonTest, SolvesTheFullSystemWithEffects) {
    constexpr int Dim = TypeParam::value;
    physics::ChainModel<double> model = model_with_everything();
    // In space the Jacobian neglects that branch moments rotate with the bond.
    if (Dim == 3)
        model.branches.clear();
    for (const double gamma : {1e-8, 1e-6, 1e-4})
        expect_solution(physics::Chain<Dim, double>(7, model, physics::consistent_law()), gamma);
}

TEST(BlockTridiagonal, ReproducesADenseSolve) {
    constexpr int size = 3;
    constexpr int count = 6;
    BlockTridiagonal<size> system(count);
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(size * count, size * count);
    std::srand(3);
    for (int i = 0; i < count; ++i) {
        const auto at = static_cast<std::size_t>(i);
        system.diagonal(at) = Eigen::Matrix3d::Random() + 4.0 * Eigen::Matrix3d::Identity();
        dense.block(size * i, size * i, size, size) = system.diagonal(at);
        system.upper(at).setRandom();
        system.lower(at).setRandom();
        if (i > 0)
            dense.block(size * i, size * (i - 1), size, size) = system.lower(at);
        if (i + 1 < count)
            dense.block(size * i, size * (i + 1), size, size) = system.upper(at);
    }
    const Eigen::VectorXd b = Eigen::VectorXd::Random(size * count);
    std::vector<Eigen::Vector3d> x(count);
    for (int i = 0; i < count; ++i)
        x[static_cast<std::size_t>(i)] = b.segment<size>(size * i);
    ASSERT_TRUE(system.factorise());
    system.solve(x);
    const Eigen::VectorXd expected = dense.partialPivLu().solve(b);
    for (int i = 0; i < count; ++i) // a well-conditioned system: about ten roundings
        EXPECT_LT((x[static_cast<std::size_t>(i)] - expected.segment<size>(size * i)).norm(),
                  1e-14 * expected.norm());
}

TEST(BlockTridiagonal, ReportsASingularBlock) {
    BlockTridiagonal<2> system(1);
    system.set_zero();
    EXPECT_FALSE(system.factorise());
}

} // namespace
} // namespace culm::integrate
