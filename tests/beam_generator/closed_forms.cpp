// SPDX-License-Identifier: BSD-3-Clause
// Compares the beam with closed-form solutions.
#include "beam_generator/beam_motion.hpp"
#include "beam_generator/constant_loss.hpp"

#include <cmath>
#include <cstdint>
#include <functional>

#include <Eigen/Eigenvalues>
#include <boost/math/quadrature/gauss.hpp>
#include <boost/math/tools/roots.hpp>
#include <boost/math/tools/toms748_solve.hpp>
#include <gtest/gtest.h>

namespace culm::beam {
namespace {

/// First frequencies as √(ω √(m'/E I)) L, the argument of the characteristic equations.
Eigen::VectorXd arguments(const BeamModel& model) {
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(
        model.stiffness_matrix(), model.mass_matrix(), Eigen::EigenvaluesOnly);
    const BeamStem& stem = model.stem();
    const double scale = std::sqrt(stem.mass_per_length() / stem.rigidity());
    return (solver.eigenvalues().array().sqrt() * scale).sqrt() * stem.length;
}

double root_between(const std::function<double(double)>& f, double low, double high) {
    std::uintmax_t iterations = 100;
    const auto bracket = boost::math::tools::toms748_solve(
        f, low, high, boost::math::tools::eps_tolerance<double>(50), iterations);
    return 0.5 * (bracket.first + bracket.second);
}

// The twelve functions give modes 1 to 3 to rounding; 1e-8 leaves room for the eigenvalue solver.
constexpr double frequency_tolerance = 1e-8;

TEST(Beam, HasTheFrequenciesOfACantilever) {
    const Eigen::VectorXd found = arguments(BeamModel(BeamStem{}, {}));
    EXPECT_NEAR(found[0], 1.8751040687119611, frequency_tolerance);
    EXPECT_NEAR(found[1], 4.6940911329741746, frequency_tolerance);
    EXPECT_NEAR(found[2], 7.8547574382376126, frequency_tolerance);
}

TEST(Beam, HasTheFrequenciesOfLauraWithATipMass) {
    const BeamStem stem;
    BeamTerms terms;
    terms.tip_mass = 0.2 * stem.mass_per_length() * stem.length;
    const auto characteristic = [](double x) {
        return 1.0 + std::cos(x) * std::cosh(x) +
               0.2 * x * (std::cos(x) * std::sinh(x) - std::sin(x) * std::cosh(x));
    };
    const Eigen::VectorXd found = arguments(BeamModel(stem, terms));
    EXPECT_NEAR(found[0], root_between(characteristic, 1.0, 1.8751), frequency_tolerance);
    EXPECT_NEAR(found[1], root_between(characteristic, 3.5, 4.694), frequency_tolerance);
}

TEST(Beam, HasTheFrequenciesOfChunInAYieldingClamp) {
    const BeamStem stem;
    BeamTerms terms;
    terms.clamp = TurningClamp{.stiffness = 20.0 * stem.rigidity() / stem.length};
    const auto characteristic = [](double x) {
        return x * (std::sin(x) * std::cosh(x) - std::cos(x) * std::sinh(x)) -
               20.0 * (1.0 + std::cos(x) * std::cosh(x));
    };
    const Eigen::VectorXd found = arguments(BeamModel(stem, terms));
    EXPECT_NEAR(found[0], root_between(characteristic, 1.0, 1.8751), frequency_tolerance);
    EXPECT_NEAR(found[1], root_between(characteristic, 4.0, 4.694), frequency_tolerance);
}

TEST(Beam, HasASecondModeOfAnotherFrequency) {
    BeamTerms terms;
    terms.second_mode = SecondMode{.frequency_share = -0.02, .loss_ratio = 1.3};
    const Eigen::VectorXd found = arguments(BeamModel(BeamStem{}, terms));
    EXPECT_NEAR(found[0], 1.8751040687119611, frequency_tolerance);
    EXPECT_NEAR(found[1], 4.6940911329741746 * std::sqrt(0.98), frequency_tolerance);
    EXPECT_NEAR(found[2], 7.8547574382376126, frequency_tolerance);
}

TEST(Beam, HasTwoFrequenciesInItsPrincipalPlanes) {
    BeamTerms terms;
    terms.is_spatial = true;
    terms.stiffness_split = 0.1;
    terms.split_angle = 0.6;
    const Eigen::VectorXd found = arguments(BeamModel(BeamStem{}, terms));
    // ω ~ √(E I), so the arguments go as (1 ± ε/2)^¼.
    EXPECT_NEAR(found[0], 1.8751040687119611 * std::pow(0.95, 0.25), frequency_tolerance);
    EXPECT_NEAR(found[1], 1.8751040687119611 * std::pow(1.05, 0.25), frequency_tolerance);
}

/// The elastica that a lateral force bends at its tip, from the angle there: E I θ'²/2 =
/// H (sin θ_L − sin θ), integrated over z = √(sin θ_L − sin θ).
struct Elastica {
    double force;
    double deflection;

    Elastica(const BeamStem& stem, double tip_angle) {
        const double end = std::sin(tip_angle);
        const auto integral = [&](auto weight) {
            return boost::math::quadrature::gauss<double, 30>::integrate(
                [&](double z) {
                    const double sine = end - z * z;
                    return 2.0 * weight(sine) / std::sqrt(1.0 - sine * sine);
                },
                0.0, std::sqrt(end));
        };
        const double arc = integral([](double) { return 1.0; });
        force = 0.5 * stem.rigidity() * arc * arc / (stem.length * stem.length);
        deflection = stem.length / arc * integral([](double sine) { return sine; });
    }
};

TEST(HeldBeam, FollowsTheElastica) {
    const BeamStem stem;
    const BeamModel model(stem, {});
    // The pulls of recordings, and a much larger one.
    for (const double angle : {0.2, 0.7}) {
        const Elastica exact(stem, angle);
        const HeldBeam held = held_at_tip(model, exact.deflection);
        // Polynomials of degree 11 describe this smooth curvature far better than the tolerance.
        EXPECT_NEAR(held.finger_force / exact.force, 1.0, 1e-8);
        // Only the constant Legendre polynomial has a nonzero integral over the whole length.
        EXPECT_NEAR(held.q[0], std::sin(angle), 1e-8);
    }
}

TEST(ConstantLoss, IsConstantInItsBand) {
    const auto branches = constant_loss(0.05, 80.0);
    for (double frequency = 40.0; frequency < 1600.0; frequency *= 1.1)
        // Ten branches over three decades ripple by less than one per cent.
        EXPECT_NEAR(loss_factor_at(branches, frequency), 0.05, 0.01 * 0.05) << frequency;
}

} // namespace
} // namespace culm::beam
