// SPDX-License-Identifier: BSD-3-Clause
// The predicted error of an explicit step against the eigenvalues of the one-step map.
#include "integrate/modes.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

namespace culm::integrate {
namespace {

/// λ of the slowest vibrating mode of the discrete motion: ln μ/h of the eigenvalue μ nearest to 1
/// of the one-step map x' = x + w, w' = w − h² M⁻¹K x' − h M⁻¹C w with w = h v, both
/// mass-normalised (in other units rounding would destroy the small differences from 1).
std::complex<double> discrete_eigenvalue(const LinearisedChain& chain, double step) {
    const Eigen::Index n = chain.mass.size();
    const Eigen::VectorXd scale = chain.mass.cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd stiffness =
        step * step * (scale.asDiagonal() * chain.stiffness * scale.asDiagonal());
    const Eigen::MatrixXd damping =
        step * (scale.asDiagonal() * chain.damping * scale.asDiagonal());
    Eigen::MatrixXd map(2 * n, 2 * n);
    map.topLeftCorner(n, n).setIdentity();
    map.topRightCorner(n, n).setIdentity();
    map.bottomLeftCorner(n, n) = -stiffness;
    map.bottomRightCorner(n, n) = Eigen::MatrixXd::Identity(n, n) - damping - stiffness;
    const Eigen::EigenSolver<Eigen::MatrixXd> solver(map, false);
    std::complex<double> slowest(0.0, 1e300);
    for (const std::complex<double>& value : solver.eigenvalues()) {
        const std::complex<double> lambda = std::log(value) / step;
        if (value.imag() > 0.0 && std::abs(lambda) < std::abs(slowest))
            slowest = lambda;
    }
    return slowest;
}

LinearisedChain oscillator(double damping) {
    return {Eigen::VectorXd::Constant(1, 2.0), Eigen::MatrixXd::Constant(1, 1, damping),
            Eigen::MatrixXd::Constant(1, 1, 50.0)};
}

TEST(StepError, MatchesLeapfrogForAnUndampedOscillator) {
    const auto mode = FirstModeStepError::of(oscillator(0.0));
    ASSERT_TRUE(mode);
    // ω = 5: sin(Ωh/2) = ωh/2, so Ω/ω − 1 = (ωh)²/24 + 3(ωh)⁴/640; the last term is 3e-11 here.
    const double step = 0.002;
    EXPECT_NEAR(mode->at(step).frequency, 1e-4 / 24.0, 1e-10);
    EXPECT_TRUE(std::isnan(mode->at(step).decay_per_cycle));
}

TEST(StepError, IsFirstOrderInTheStepForADampedOscillator) {
    const auto mode = FirstModeStepError::of(oscillator(1.0));
    ASSERT_TRUE(mode);
    // s²(1 − hc/2) + cs + ω² = 0 with c = 0.5 per mass: the frequency rises by hc/4 at first
    // order in h, up to a relative correction of ζ² = 2.5e-3; the decay rate rises by hc/2.
    const double step = 1e-4;
    const StepError error = mode->at(step);
    EXPECT_NEAR(error.frequency / (step * 0.5 / 4.0), 1.0, 0.02);
    EXPECT_NEAR(error.decay_per_cycle / (step * 0.5 / 4.0), 1.0, 0.02);
    EXPECT_NEAR(mode->at(2 * step).frequency / error.frequency, 2.0, 2e-3);
}

TEST(StepError, MatchesTheOneStepMapOfAChainForBothLaws) {
    for (const auto& law : {physics::schramm2019_law(), physics::consistent_law()}) {
        physics::StemParameters<double> stem;
        stem.sphere_count = 5;
        stem.bond_damping = 3.0;
        const LinearisedChain chain = linearise_transverse(stem, law);
        const auto mode = FirstModeStepError::of(chain);
        ASSERT_TRUE(mode);
        const double step = 0.5 * largest_stable_step(chain);
        const std::complex<double> exact = mode->eigenvalue();
        const std::complex<double> discrete = discrete_eigenvalue(chain, step);
        const StepError error = mode->at(step);
        const double of_frequency = discrete.imag() / exact.imag() - 1.0;
        const double of_decay = discrete.real() / exact.real() / (1.0 + of_frequency) - 1.0;
        // The errors are about 1e-4. First-order perturbation neglects their square times the ratio
        // of the fast modes' forces; the eigenvalues of the map are accurate to 1e-11.
        EXPECT_NEAR(error.frequency / of_frequency, 1.0, 0.01);
        EXPECT_NEAR(error.decay_per_cycle / of_decay, 1.0, 0.01);
        EXPECT_GT(std::abs(of_frequency), 1e-6);
    }
}

TEST(StepError, IsUndefinedWhereNothingVibrates) {
    EXPECT_FALSE(FirstModeStepError::of(oscillator(1e3)));
}

} // namespace
} // namespace culm::integrate
