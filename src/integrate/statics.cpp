// SPDX-License-Identifier: BSD-3-Clause
#include "integrate/statics.hpp"

#include "core/error.hpp"
#include "integrate/block_tridiagonal.hpp"
#include "integrate/bond_jacobian.hpp"

#include <algorithm>
#include <cmath>

#include <ceres/jet.h>
#include <fmt/core.h>

namespace culm::integrate {
namespace {

/// Load steps for a tip deflection of one free length; the first few serve small deflections.
constexpr double load_steps_per_slope = 200.0;
constexpr int least_load_steps = 10;
/// Newton has converged when the largest displacement or rotation of an iteration, relative to the
/// bond length or one radian, falls below this; one more iteration then squares what is left.
constexpr double newton_tolerance = 1e-10;
constexpr int newton_limit = 30;
constexpr int halving_limit = 12;

/// One load step of the chain: displacements and rotations of the spheres are the unknowns.
template <int Dim>
class LoadStep {
    static constexpr int rotation = physics::rotation_dimension<Dim>;
    static constexpr int block = Dim + rotation;
    using Dual = ceres::Jet<double, 2 * block>;
    using Blocks = BlockTridiagonal<block>;
    using Column = typename Blocks::Column;

  public:
    explicit LoadStep(const physics::Chain<Dim, double>& chain)
        : chain_(chain), bond_(as_dual<Dual>(chain.bond_coefficients())),
          blocks_(chain.layout().sphere_count()), increment_(blocks_.block_count(), Column::Zero()),
          residual_(blocks_.block_count(), Column::Zero()) {}

    /// Moves `state` to the equilibrium under `load` times gravity with the tip at
    /// `tip_deflection`. Returns the iterations used, or 0 without touching `state` on failure.
    [[nodiscard]] int advance(std::vector<double>& state, double tip_deflection, double load) {
        const auto& layout = chain_.layout();
        const double to_go =
            tip_deflection - layout.sphere(state.data(), layout.bond_count()).position[1];
        std::fill(increment_.begin(), increment_.end(), Column::Zero());
        bool converged = false;
        for (int iteration = 1; iteration <= newton_limit; ++iteration) {
            assemble(state, load, to_go);
            if (!blocks_.factorise())
                return 0;
            blocks_.solve(residual_);
            double largest = 0.0;
            for (std::size_t i = 0; i < increment_.size(); ++i) {
                increment_[i] -= residual_[i];
                largest = std::max({largest,
                                    residual_[i].template head<Dim>().cwiseAbs().maxCoeff() /
                                        chain_.bond_coefficients().length,
                                    residual_[i].template tail<rotation>().cwiseAbs().maxCoeff()});
            }
            if (!std::isfinite(largest))
                return 0;
            if (converged) {
                commit(state);
                return iteration;
            }
            converged = largest < newton_tolerance;
        }
        return 0;
    }

    /// Lateral force that the last bond exerts on the tip's support after advance().
    [[nodiscard]] double holding_force(const std::vector<double>& state) const {
        const auto& layout = chain_.layout();
        const int last = layout.bond_count() - 1;
        auto motion = chain_.motion_between(layout.sphere(state.data(), last),
                                            layout.sphere(state.data(), last + 1));
        const physics::BondFrame<Dim, double> frame(motion.separation);
        const auto response =
            physics::bond_response(chain_.bond_coefficients(), chain_.law(), frame, motion,
                                   layout.bond(state.data(), last));
        return response.force[1] - chain_.sphere_inertia().mass * chain_.gravity()[1];
    }

  private:
    /// Forces of bond `j` at the end of the step, and its new history, as functions of the
    /// displacements and rotations of its two spheres.
    struct BondAtRest {
        physics::BondState<Dim, Dual> history;
        physics::BondResponse<Dim, Dual> response;
    };

    [[nodiscard]] [[gnu::flatten]] BondAtRest evaluate(const std::vector<double>& state,
                                                       int j) const {
        const auto& layout = chain_.layout();
        const auto start = chain_.motion_between(layout.sphere(state.data(), j),
                                                 layout.sphere(state.data(), j + 1));
        const auto old = layout.bond(state.data(), j);
        const auto& increment_1 = increment_[static_cast<std::size_t>(j)];
        const auto& increment_2 = increment_[static_cast<std::size_t>(j) + 1];

        physics::BondMotion<Dim, Dual> motion;
        core::Vec<Dim, Dual> old_separation;
        for (int k = 0; k < Dim; ++k) {
            old_separation[k] = Dual(start.separation[k]);
            motion.velocity[k] = Dual(increment_2(k), block + k) - Dual(increment_1(k), k);
        }
        physics::BondState<Dim, Dual> history;
        for (int k = 0; k < rotation; ++k) {
            motion.spin_1[k] = Dual(increment_1(Dim + k), Dim + k);
            motion.spin_2[k] = Dual(increment_2(Dim + k), block + Dim + k);
            history.shear_force[k] = Dual(old.shear_force[k]);
            history.moment[k] = Dual(old.moment[k]);
        }
        const core::Vec<Dim, Dual> new_separation = old_separation + motion.velocity;
        motion.separation = old_separation + Dual(0.5) * motion.velocity;

        const physics::BondFrame<Dim, Dual> before(old_separation);
        const physics::BondFrame<Dim, Dual> middle(motion.separation);
        const physics::BondFrame<Dim, Dual> after(new_separation);
        history.shear_force = middle.turned_shear(history.shear_force);
        history.moment = middle.turned_moment(history.moment, before.direction());
        const auto rates = physics::bond_response(bond_, chain_.law(), middle, motion, history);
        history.shear_force = after.turned_shear(history.shear_force + rates.rate.shear_force);
        history.moment =
            after.turned_moment(history.moment + rates.rate.moment, middle.direction());

        physics::BondMotion<Dim, Dual> rest;
        rest.separation = new_separation;
        rest.velocity = core::Vec<Dim, Dual>::zero();
        rest.spin_1 = physics::Rotational<Dim, Dual>::zero();
        rest.spin_2 = physics::Rotational<Dim, Dual>::zero();
        return {history, physics::bond_response(bond_, chain_.law(), after, rest, history)};
    }

    /// Out-of-balance forces and their derivatives at the present increment.
    void assemble(const std::vector<double>& state, double load, double to_go) {
        blocks_.set_zero();
        const std::size_t last = blocks_.block_count() - 1;
        for (std::size_t i = 0; i <= last; ++i) {
            residual_[i].setZero();
            for (int k = 0; k < Dim; ++k)
                residual_[i](k) = load * chain_.sphere_inertia().mass * chain_.gravity()[k];
        }
        for (std::size_t j = 0; j < last; ++j)
            add_bond(j, evaluate(state, static_cast<int>(j)).response);

        blocks_.diagonal(0).setIdentity();
        blocks_.upper(0).setZero();
        residual_[0] = increment_[0];
        blocks_.diagonal(last).row(1).setZero();
        blocks_.lower(last).row(1).setZero();
        blocks_.diagonal(last)(1, 1) = 1.0;
        residual_[last](1) = increment_[last](1) - to_go;
    }

    void add_bond(std::size_t j, const physics::BondResponse<Dim, Dual>& response) {
        const auto add = [this, j](int row, const Dual& on_1, const Dual& on_2) {
            residual_[j](row) += on_1.a;
            residual_[j + 1](row) += on_2.a;
            blocks_.diagonal(j).row(row) += on_1.v.template head<block>().transpose();
            blocks_.upper(j).row(row) += on_1.v.template tail<block>().transpose();
            blocks_.lower(j + 1).row(row) += on_2.v.template head<block>().transpose();
            blocks_.diagonal(j + 1).row(row) += on_2.v.template tail<block>().transpose();
        };
        for (int k = 0; k < Dim; ++k)
            add(k, response.force[k], -response.force[k]);
        for (int k = 0; k < rotation; ++k)
            add(Dim + k, response.torque_1[k], response.torque_2[k]);
    }

    void commit(std::vector<double>& state) const {
        const auto& layout = chain_.layout();
        std::vector<physics::BondState<Dim, double>> histories;
        for (int j = 0; j < layout.bond_count(); ++j) {
            const physics::BondState<Dim, Dual> history = evaluate(state, j).history;
            physics::BondState<Dim, double> value;
            for (int k = 0; k < rotation; ++k) {
                value.shear_force[k] = history.shear_force[k].a;
                value.moment[k] = history.moment[k].a;
            }
            histories.push_back(value);
        }
        for (int i = 0; i < layout.sphere_count(); ++i) {
            auto sphere = layout.sphere(state.data(), i);
            for (int k = 0; k < Dim; ++k)
                sphere.position[k] += increment_[static_cast<std::size_t>(i)](k);
            layout.set_sphere(state.data(), i, sphere);
        }
        for (int j = 0; j < layout.bond_count(); ++j)
            layout.set_bond(state.data(), j, histories[static_cast<std::size_t>(j)]);
    }

    const physics::Chain<Dim, double>& chain_;
    physics::BondCoefficients<Dual> bond_;
    Blocks blocks_;
    std::vector<Column> increment_; ///< displacement (m) and rotation (rad) of each sphere
    std::vector<Column> residual_;
};

} // namespace

template <int Dim>
StaticState deflected_equilibrium(const physics::Chain<Dim, double>& chain, double tip_deflection) {
    const auto& layout = chain.layout();
    const double free_length = chain.bond_coefficients().length * layout.bond_count();
    StaticState result{chain.straight_state(), 0.0, 0};
    LoadStep<Dim> step(chain);

    double fraction = 0.0;
    double stride = 1.0 / (least_load_steps + std::ceil(load_steps_per_slope *
                                                        std::abs(tip_deflection) / free_length));
    int halvings = 0;
    while (fraction < 1.0) {
        const double next = fraction + stride > 1.0 - 1e-9 ? 1.0 : fraction + stride;
        const int iterations = step.advance(result.state, next * tip_deflection, next);
        if (iterations > 0) {
            fraction = next;
            result.newton_iterations += iterations;
            continue;
        }
        stride *= 0.5;
        if (++halvings > halving_limit)
            throw core::NumericalError(
                core::FailureKind::StaticFailed,
                fmt::format("no equilibrium found beyond a tip deflection of {:.4g} mm "
                            "({:.4g} mm were asked for, the stem is {:.4g} mm long)",
                            fraction * tip_deflection * 1e3, tip_deflection * 1e3,
                            free_length * 1e3));
    }
    result.holding_force = step.holding_force(result.state);
    return result;
}

template StaticState deflected_equilibrium<2>(const physics::Chain<2, double>&, double);
template StaticState deflected_equilibrium<3>(const physics::Chain<3, double>&, double);

} // namespace culm::integrate
