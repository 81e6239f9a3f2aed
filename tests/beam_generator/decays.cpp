// SPDX-License-Identifier: BSD-3-Clause
// The decay of the beam's motion and the balance of its energy.
#include "beam_generator/beam_motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

namespace culm::beam {
namespace {

/// A mode, with a tip deflection of 1.
struct Mode {
    Eigen::VectorXd shape;
    double omega = 0.0;
    double mass = 0.0;
    Eigen::VectorXd projector; ///< coordinates to the mode's amplitude

    explicit Mode(const BeamModel& model, Eigen::Index place = 0) {
        const Eigen::MatrixXd inertia = model.mass_matrix();
        const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(
            model.stiffness_matrix(), inertia);
        omega = std::sqrt(solver.eigenvalues()[place]);
        shape = solver.eigenvectors().col(place);
        shape /= model.finger_direction().dot(shape);
        mass = shape.dot(inertia * shape);
        projector = inertia * shape / mass;
    }
};

/// Amplitudes of the mode at the turning points on the side of the pull, the release excepted.
std::vector<double> turning_points(const BeamMotion& motion, const Mode& mode) {
    std::vector<double> amplitudes;
    for (std::size_t k = 1; k + 1 < motion.q.size(); ++k) {
        const double before = mode.projector.dot(motion.q[k - 1]);
        const double now = mode.projector.dot(motion.q[k]);
        const double after = mode.projector.dot(motion.q[k + 1]);
        if (now <= 0.0 || now < before || now <= after)
            continue;
        // Vertex of the parabola through the three.
        const double bend = before - 2.0 * now + after;
        amplitudes.push_back(now - (after - before) * (after - before) / (8.0 * bend));
    }
    return amplitudes;
}

/// Releases the shape of the mode alone, because the formulas neglect the others.
BeamMotion released(const BeamModel& model, const Mode& mode, double amplitude, double duration) {
    return release(model, {amplitude * mode.shape, 0.0}, duration, default_step(model));
}

BeamStem undamped() {
    BeamStem stem;
    stem.damping_time = 0.0;
    return stem;
}

/// Logarithmic decrement of a mode that is released alone with a small amplitude.
double measured_decrement(const BeamModel& model, const Mode& mode, double duration) {
    const auto peaks = turning_points(released(model, mode, 1e-4, duration), mode);
    EXPECT_GT(peaks.size(), 9u);
    return std::log(peaks.at(1) / peaks.at(7)) / 6.0;
}

double decrement_of(double zeta) {
    return 2.0 * std::numbers::pi * zeta / std::sqrt(1.0 - zeta * zeta);
}

TEST(Decay, IsExponentialWithInternalDamping) {
    const BeamStem stem;
    const BeamModel model(stem, {});
    const Mode mode(model);
    // ζ = ½ ω τ; small swings, so only the integrator and the parabola have errors.
    EXPECT_NEAR(measured_decrement(model, mode, 0.2) /
                    decrement_of(0.5 * mode.omega * stem.damping_time),
                1.0, 1e-3);
}

TEST(Decay, OfTheSecondModeHasItsOwnLoss) {
    const BeamStem stem;
    BeamTerms terms;
    terms.second_mode = SecondMode{.frequency_share = 0.02, .loss_ratio = 0.7};
    const BeamModel model(stem, terms);
    const Mode mode(model, 1);
    const double omega = Mode(BeamModel(stem, {}), 1).omega;
    // A period has fewer steps of the integrator than one of mode 1.
    EXPECT_NEAR(measured_decrement(model, mode, 0.05) /
                    decrement_of(0.5 * 0.7 * omega * stem.damping_time / 1.02),
                1.0, 0.01);
    EXPECT_NEAR(measured_decrement(model, Mode(model), 0.2) /
                    decrement_of(0.5 * Mode(model).omega * stem.damping_time),
                1.0, 1e-3);
}

TEST(Decay, IsExponentialWithALossyClamp) {
    const BeamStem stem = undamped();
    BeamTerms terms;
    terms.clamp = TurningClamp{.stiffness = 20.0 * stem.rigidity() / stem.length, .damping = 2e-5};
    const BeamModel model(stem, terms);
    const Mode mode(model);
    // 2 ζ ω M = c θ², with the clamp's rotation θ for a tip deflection of 1.
    const double zeta = 2e-5 * std::pow(mode.shape[0], 2) / (2.0 * mode.omega * mode.mass);
    EXPECT_NEAR(measured_decrement(model, mode, 0.2) / decrement_of(zeta), 1.0, 5e-3);
}

TEST(Decay, IsHyperbolicWithQuadraticDrag) {
    BeamTerms terms;
    terms.quadratic_drag = 5e-3;
    const BeamModel model(undamped(), terms);
    const Mode mode(model);
    const auto peaks = turning_points(released(model, mode, 10e-3, 0.3), mode);
    ASSERT_GT(peaks.size(), 20u);
    // The power of −c |v| v per length over a cycle: dA/dt = −(4/3π) (ω c ∫|φ|³ ds/M) A².
    const Eigen::ArrayXd shape =
        (model.grid().deflection * mode.shape).head(model.grid().points()).array();
    const double cubes = model.grid().weight.dot(shape.abs().cube().matrix());
    const double rate = 4.0 / (3.0 * std::numbers::pi) * mode.omega * 5e-3 * cubes / mode.mass;
    const double period = 2.0 * std::numbers::pi / mode.omega;
    const double early = 1.0 / peaks[10] - 1.0 / peaks[1];
    const double late = 1.0 / peaks[19] - 1.0 / peaks[10];
    // The formula is the first order in a loss of 4 % a cycle, and for small swings.
    EXPECT_NEAR(early / (9.0 * period * rate), 1.0, 0.01);
    EXPECT_NEAR(late / early, 1.0, 0.01);
}

TEST(Decay, FollowsThePowerOfTheDrag) {
    constexpr double exponent = 1.6;
    BeamTerms terms;
    terms.power_drag = PowerDrag{.coefficient = 5e-3, .exponent = exponent};
    const BeamModel model(undamped(), terms);
    const Mode mode(model);
    const auto peaks = turning_points(released(model, mode, 10e-3, 0.3), mode);
    ASSERT_GT(peaks.size(), 20u);
    // dA/dt = −K Aᵖ, as for quadratic drag.
    const auto steps = [&](std::size_t from, std::size_t to) {
        return std::pow(peaks[to], 1.0 - exponent) - std::pow(peaks[from], 1.0 - exponent);
    };
    EXPECT_NEAR(steps(10, 19) / steps(1, 10), 1.0, 0.01);
    EXPECT_GT(peaks[1] / peaks[19], 1.2);
}

TEST(Decay, IsLinearWithDryFriction) {
    const BeamStem stem = undamped();
    BeamTerms terms;
    terms.clamp = TurningClamp{.stiffness = 20.0 * stem.rigidity() / stem.length,
                               .friction_moment = 1e-4,
                               .friction_rate = 0.01};
    const BeamModel model(stem, terms);
    const Mode mode(model);
    const auto peaks = turning_points(released(model, mode, 10e-3, 0.2), mode);
    ASSERT_GT(peaks.size(), 10u);
    // A cycle loses 4 M_f Θ of ½ M ω² A², with the clamp's rotation Θ = θ_1 A.
    const double lost = 4.0 * 1e-4 * mode.shape[0] / (mode.mass * mode.omega * mode.omega);
    // Reversals of the friction excite a little of mode 2, which also loses energy.
    EXPECT_NEAR((peaks[1] - peaks[5]) / (4.0 * lost), 1.0, 0.02);
    EXPECT_NEAR((peaks[5] - peaks[9]) / (4.0 * lost), 1.0, 0.02);
}

TEST(Energy, IsConservedWithoutLosses) {
    BeamTerms terms;
    terms.cubic_bending = -0.01;
    terms.tip_mass = 1e-5;
    terms.taper = -0.1;
    terms.axial_gravity = -9.81;
    terms.transverse_gravity = 3.0;
    terms.base_curvature = 0.3;
    terms.segment = WeakSegment{0.05, 0.005, 0.5};
    terms.clamp = TurningClamp{.stiffness = 1.0};
    terms.is_spatial = true;
    terms.stiffness_split = 0.1;
    terms.split_angle = 0.5;
    // The split's energy is not in BeamModel::energy's cubic part, so the two are tried apart.
    for (const bool is_spatial : {false, true}) {
        terms.is_spatial = is_spatial;
        const BeamModel model(undamped(), terms);
        const HeldBeam held = held_at_tip(model, 20e-3);
        const Eigen::VectorXd rest = Eigen::VectorXd::Zero(model.freedoms());
        const double start = model.energy(held.q, rest);
        const BeamMotion motion = release(model, held, 0.05, 0.25 * default_step(model));
        double worst = 0.0;
        for (std::size_t k = 0; k < motion.q.size(); ++k)
            worst = std::max(worst, std::abs(model.energy(motion.q[k], motion.v[k]) / start - 1.0));
        // The integrator damps modes above the fourth, which contain some 1e-5 of the energy.
        EXPECT_LT(worst, 1e-4) << is_spatial;
    }
}

TEST(Energy, FallsByTheLossesToDampingAndDrag) {
    const BeamStem stem;
    BeamTerms terms;
    terms.quadratic_drag = 2e-3;
    terms.linear_drag = 1e-3;
    terms.curvature_damping = 1e-5;
    const BeamModel model(stem, terms);
    const BeamModel conservative(undamped(), {});
    const HeldBeam held = held_at_tip(model, 20e-3);
    const BeamMotion motion = release(model, held, 0.03, 0.25 * default_step(model));
    const Eigen::VectorXd still = Eigen::VectorXd::Zero(model.freedoms());
    const auto loss_rate = [&](std::size_t k) {
        const BeamState state{motion.q[k], motion.v[k], still, 0.0};
        return motion.v[k].dot(model.out_of_balance(state, 0.0, {}) -
                               conservative.out_of_balance(state, 0.0, {}));
    };
    double lost = 0.0;
    for (std::size_t k = 0; k + 1 < motion.q.size(); ++k)
        lost += 0.5 * motion.step * (loss_rate(k) + loss_rate(k + 1));
    const double start = model.energy(held.q, still);
    const double end = model.energy(motion.q.back(), motion.v.back());
    EXPECT_GT(lost, 0.2 * start);
    // Trapezoids miss some of the first milliseconds' fast modes.
    EXPECT_NEAR((start - end) / lost, 1.0, 1e-3);
}

} // namespace
} // namespace culm::beam
