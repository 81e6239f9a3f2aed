// SPDX-License-Identifier: BSD-3-Clause
#include "beam_generator/beam_motion.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <boost/math/tools/roots.hpp>
#include <boost/math/tools/toms748_solve.hpp>
#include <fmt/core.h>

namespace culm::beam {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t stages = 5;
constexpr double diagonal = 0.25;
constexpr std::array<double, stages> stage_time{0.25, 0.75, 11.0 / 20.0, 0.5, 1.0};
constexpr std::array<std::array<double, stages>, stages> stage_weight{
    {{0.25, 0.0, 0.0, 0.0, 0.0},
     {0.5, 0.25, 0.0, 0.0, 0.0},
     {17.0 / 50.0, -1.0 / 25.0, 0.25, 0.0, 0.0},
     {371.0 / 1360.0, -137.0 / 2720.0, 15.0 / 544.0, 0.25, 0.0},
     {25.0 / 24.0, -49.0 / 48.0, 125.0 / 16.0, -85.0 / 12.0, 0.25}}};

/// A stage has converged when an iteration changes no coordinate (of order 0.1) by more.
constexpr double stage_tolerance = 1e-11;
constexpr int stage_iterations = 100;

double finger_share(double time, double duration) {
    if (time >= duration)
        return 0.0;
    const double u = std::max(time, 0.0) / duration;
    return 1.0 - u * u * (3.0 - 2.0 * u);
}

/// The force F = law(z + stiffness⁻¹ F, rate + …): a law that falls with both has exactly one.
double implicit_force(const PointLaw& law, double z, double rate, double z_by_force,
                      double rate_by_force) {
    const auto excess = [&](double force) {
        return force - law.force(z + z_by_force * force, rate + rate_by_force * force);
    };
    const double explicit_force = law.force(z, rate);
    const double at_zero = -explicit_force;
    const double at_explicit = excess(explicit_force);
    if (at_zero == 0.0 || at_explicit == 0.0 || (at_zero < 0.0) == (at_explicit < 0.0))
        return explicit_force;
    std::uintmax_t iterations = 100;
    const bool is_positive = explicit_force > 0.0;
    const auto bracket = boost::math::tools::toms748_solve(
        excess, is_positive ? 0.0 : explicit_force, is_positive ? explicit_force : 0.0,
        is_positive ? at_zero : at_explicit, is_positive ? at_explicit : at_zero,
        boost::math::tools::eps_tolerance<double>(48), iterations);
    return 0.5 * (bracket.first + bracket.second);
}

/// Steps of one size through a free motion.
class Stepper {
  public:
    Stepper(const BeamModel& model, const HeldBeam& held, double step)
        : model_(model), finger_(held.finger_force), step_(step),
          implicit_(diagonal * step), now_{held.q, VectorXd::Zero(model.freedoms()),
                                           VectorXd::Zero(model.freedoms()), 0.0},
          branches_(model.held_branches(held.q)) {
        factorise();
        forces_.assign(model.point_laws().size(), 0.0);
        arrive();
        for (std::size_t i = 0; i < stages; ++i)
            branch_rates_[i] = BranchMoments::Zero(branches_.rows(), branches_.cols());
    }

    [[nodiscard]] const BeamState& now() const { return now_; }

    void advance() {
        if (model_.terms().curvature_damping != 0.0 || model_.terms().strain_loss)
            factorise();
        for (std::size_t i = 0; i < stages; ++i)
            solve_stage(i);
        // The last stage is the end of the step.
        now_.q = last_.q;
        now_.v = last_.v;
        now_.a = last_.a;
        now_.time += step_;
        arrive();
        for (std::size_t i = 0; i < stages; ++i)
            branches_ += step_ * stage_weight[stages - 1][i] * branch_rates_[i];
    }

  private:
    /// The stages' common matrix, for a nearly straight stem: iterations do the rest.
    void factorise() {
        tangent_.compute(model_.mass_matrix() +
                         implicit_ * model_.damping_matrix(implicit_, now_.q) +
                         implicit_ * implicit_ * model_.stiffness_matrix());
        responses_.clear();
        for (const PointLaw& law : model_.point_laws())
            responses_.push_back(tangent_.solve(law.direction));
    }

    void arrive() {
        for (const PointLaw& law : model_.point_laws())
            if (law.arrive)
                law.arrive(law.direction.dot(now_.q));
    }

    void solve_stage(std::size_t i) {
        VectorXd q = now_.q;
        VectorXd v = now_.v;
        BranchMoments branches = branches_;
        for (std::size_t j = 0; j < i; ++j) {
            const double weight = step_ * stage_weight[i][j];
            q += weight * velocities_[j];
            v += weight * accelerations_[j];
            branches += weight * branch_rates_[j];
        }
        BeamState at{q, v, i == 0 ? now_.a : accelerations_[i - 1],
                     now_.time + stage_time[i] * step_};
        const double release_duration = model_.terms().release_duration;
        const double finger =
            release_duration > 0.0 ? finger_ * finger_share(at.time, release_duration) : 0.0;
        double change = 0.0;
        for (int iteration = 0; iteration < stage_iterations; ++iteration) {
            at.v = v + implicit_ * at.a;
            at.q = q + implicit_ * at.v;
            const VectorXd unbalanced =
                model_.out_of_balance(at, finger, {&branches, implicit_}, &branch_rates_[i]);
            const VectorXd better = with_point_laws(at.a - tangent_.solve(unbalanced), q, v);
            change = implicit_ * implicit_ * (better - at.a).cwiseAbs().maxCoeff();
            at.a = better;
            if (!(change > stage_tolerance))
                break;
        }
        if (!(change <= stage_tolerance))
            throw core::NumericalError(
                core::FailureKind::SolverFailed,
                fmt::format("the beam's step at {:.6g} s does not converge: change {:.3g}", at.time,
                            change));
        at.v = v + implicit_ * at.a;
        at.q = q + implicit_ * at.v;
        velocities_[i] = at.v;
        accelerations_[i] = at.a;
        last_ = std::move(at);
    }

    /// Adds the contributions of the point laws to the accelerations, one after the other.
    [[nodiscard]] VectorXd with_point_laws(VectorXd acceleration, const VectorXd& q,
                                           const VectorXd& v) {
        const auto& laws = model_.point_laws();
        for (std::size_t k = 0; k < laws.size(); ++k)
            acceleration += forces_[k] * responses_[k];
        for (std::size_t k = 0; k < laws.size(); ++k) {
            acceleration -= forces_[k] * responses_[k];
            const VectorXd velocity = v + implicit_ * acceleration;
            const double z = laws[k].direction.dot(q + implicit_ * velocity);
            const double by_force = laws[k].direction.dot(responses_[k]);
            forces_[k] = implicit_force(laws[k], z, laws[k].direction.dot(velocity),
                                        implicit_ * implicit_ * by_force, implicit_ * by_force);
            acceleration += forces_[k] * responses_[k];
        }
        return acceleration;
    }

    const BeamModel& model_;
    double finger_;
    double step_;
    double implicit_;
    BeamState now_;
    BranchMoments branches_;
    Eigen::LDLT<MatrixXd> tangent_;
    std::vector<VectorXd> responses_; ///< accelerations by unit forces of the point laws
    std::vector<double> forces_;
    std::array<VectorXd, stages> velocities_;
    std::array<VectorXd, stages> accelerations_;
    std::array<BranchMoments, stages> branch_rates_;
    BeamState last_;
};

/// Derivative of the forces at rest by the coordinates, by differences.
MatrixXd stiffness_at(const BeamModel& model, const VectorXd& q, double finger) {
    constexpr double difference = 1e-6;
    MatrixXd stiffness(model.freedoms(), model.freedoms());
    for (Index k = 0; k < model.freedoms(); ++k) {
        const VectorXd shift = difference * VectorXd::Unit(model.freedoms(), k);
        stiffness.col(k) = (model.out_of_balance_at_rest(q + shift, finger) -
                            model.out_of_balance_at_rest(q - shift, finger)) /
                           (2.0 * difference);
    }
    return stiffness;
}

} // namespace

HeldBeam held_at_tip(const BeamModel& model, double tip_deflection) {
    constexpr int load_steps = 4;
    constexpr int iterations = 30;
    constexpr double tolerance = 1e-11; // of coordinates of order 0.1
    const Index n = model.freedoms();
    const VectorXd tip = model.finger_direction();
    HeldBeam held{VectorXd::Zero(n), 0.0};
    for (int load = 1; load <= load_steps; ++load) {
        const double wanted = tip_deflection * load / load_steps;
        double change = 1.0;
        for (int k = 0; k < iterations && change > tolerance; ++k) {
            MatrixXd matrix = MatrixXd::Zero(n + 1, n + 1);
            matrix.topLeftCorner(n, n) = stiffness_at(model, held.q, held.finger_force);
            matrix.topRightCorner(n, 1) = -tip;
            matrix.bottomLeftCorner(1, n) = tip.transpose();
            VectorXd unbalanced(n + 1);
            unbalanced.head(n) = model.out_of_balance_at_rest(held.q, held.finger_force);
            unbalanced[n] = tip.dot(held.q) - wanted;
            const VectorXd step = matrix.fullPivLu().solve(unbalanced);
            held.q -= step.head(n);
            held.finger_force -= step[n];
            change = step.head(n).cwiseAbs().maxCoeff();
        }
        if (!(change <= tolerance))
            throw core::NumericalError(
                core::FailureKind::StaticFailed,
                fmt::format("the beam finds no equilibrium with its tip at {:.4g} m", wanted));
    }
    return held;
}

VectorXd BeamMotion::coordinates(double time) const {
    if (time <= 0.0)
        return q.front();
    const double place = time / step;
    const auto last = q.size() - 2;
    const std::size_t k = std::min(static_cast<std::size_t>(place), last);
    const double u = place - static_cast<double>(k);
    return (1.0 + 2.0 * u) * (1.0 - u) * (1.0 - u) * q[k] +
           step * u * (1.0 - u) * (1.0 - u) * v[k] + u * u * (3.0 - 2.0 * u) * q[k + 1] +
           step * u * u * (u - 1.0) * v[k + 1];
}

double default_step(const BeamModel& model) {
    const BeamTerms& terms = model.terms();
    const bool has_friction = terms.clamp && (terms.clamp->friction_moment != 0.0 || terms.slip);
    const double steps_a_period = terms.stop ? 800.0 : has_friction ? 400.0 : 120.0;
    return 1.0 / (steps_a_period * model.stem().first_frequency());
}

BeamMotion release(const BeamModel& model, const HeldBeam& held, double duration, double step) {
    Stepper stepper(model, held, step);
    BeamMotion motion{step, {}, {}};
    const auto steps = static_cast<std::size_t>(std::ceil(duration / step)) + 1;
    for (std::size_t k = 0; k <= steps; ++k) {
        motion.q.push_back(stepper.now().q);
        motion.v.push_back(stepper.now().v);
        if (k < steps)
            stepper.advance();
    }
    return motion;
}

} // namespace culm::beam
