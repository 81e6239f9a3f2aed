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
/// bond length or one radian, falls below this; one more iteration then squares the remaining
/// error.
constexpr double newton_tolerance = 1e-6;
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
    LoadStep(const physics::Chain<Dim, double>& chain, std::span<const double> lateral_loads)
        : chain_(chain), lateral_loads_(lateral_loads),
          bending_(as_dual<Dual>(chain.model().bending)), blocks_(chain.layout().sphere_count()),
          increment_(blocks_.block_count(), Column::Zero()),
          residual_(blocks_.block_count(), Column::Zero()) {}

    /// Moves `state` to the equilibrium under `load` times gravity with the tip at
    /// `tip_deflection`; false, without touching `state`, if there is none nearby.
    [[nodiscard]] bool advance(std::vector<double>& state, double tip_deflection, double load) {
        const double load_at_start = load_;
        if (iterate(state, tip_deflection, load))
            return true;
        load_ = load_at_start;
        std::fill(increment_.begin(), increment_.end(), Column::Zero());
        return false;
    }

    /// Lateral force that the last bond exerts on the tip's support after advance().
    [[nodiscard]] double holding_force(const std::vector<double>& state) const {
        const auto& layout = chain_.layout();
        const int last = layout.bond_count() - 1;
        auto motion = chain_.motion_between(layout.sphere(state.data(), last),
                                            layout.sphere(state.data(), last + 1));
        const physics::BondFrame<Dim, double> frame(motion.separation);
        // Only the normal and the shear force contribute, which no effect changes.
        const auto response =
            physics::bond_response(chain_.bond_coefficients(last), chain_.law(), frame, motion,
                                   layout.bond(state.data(), last));
        const auto tip = layout.sphere(state.data(), last + 1);
        return response.force[1] - chain_.sphere_inertia(last + 1).mass * chain_.gravity()[1] -
               node_load_at_rest(last + 1, tip, state).force[1];
    }

  private:
    [[nodiscard]] bool iterate(std::vector<double>& state, double tip_deflection, double load) {
        const auto& layout = chain_.layout();
        load_before_ = load_;
        load_ = load;
        const double to_go =
            tip_deflection - layout.sphere(state.data(), layout.bond_count()).position[1];
        bool converged = false; // starts from the increment of the preceding load step
        for (int iteration = 0; iteration < newton_limit; ++iteration) {
            assemble(state, to_go);
            if (!blocks_.factorise())
                return false;
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
                return false;
            if (converged) {
                commit(state);
                return true;
            }
            converged = largest < newton_tolerance;
        }
        return false;
    }

    template <int N>
    [[nodiscard]] static core::Vec<N, Dual> constants(const core::Vec<N, double>& numbers) {
        core::Vec<N, Dual> duals;
        std::ranges::transform(numbers.component, duals.component.begin(),
                               [](double number) { return Dual(number); });
        return duals;
    }
    template <int N>
    [[nodiscard]] static core::Vec<N, double> values_of(const core::Vec<N, Dual>& duals) {
        core::Vec<N, double> values;
        std::ranges::transform(duals.component, values.component.begin(), &Dual::a);
        return values;
    }

    /// Forces of bond `j` at the end of the step, and its new history, as functions of the
    /// displacements and rotations of its two spheres.
    struct BondAtRest {
        physics::BondState<Dim, Dual> history;
        physics::BondResponse<Dim, Dual> response;
    };

    [[nodiscard]] [[gnu::flatten]] BondAtRest evaluate(const std::vector<double>& state,
                                                       int j) const {
        const auto& layout = chain_.layout();
        const physics::BondCoefficients<Dual> bond = as_dual<Dual>(chain_.bond_coefficients(j));
        const auto start = chain_.motion_between(layout.sphere(state.data(), j),
                                                 layout.sphere(state.data(), j + 1));
        const auto old = layout.bond(state.data(), j);
        const auto& increment_1 = increment_[static_cast<std::size_t>(j)];
        const auto& increment_2 = increment_[static_cast<std::size_t>(j) + 1];

        physics::BondMotion<Dim, Dual> motion;
        for (int k = 0; k < Dim; ++k)
            motion.velocity[k] = Dual(increment_2(k), block + k) - Dual(increment_1(k), k);
        for (int k = 0; k < rotation; ++k) {
            motion.spin_1[k] = Dual(increment_1(Dim + k), Dim + k);
            motion.spin_2[k] = Dual(increment_2(Dim + k), block + Dim + k);
        }
        physics::BondState<Dim, Dual> history{constants(old.shear_force), constants(old.moment)};
        if (!chain_.model().straight_moments.empty())
            history.moment[physics::bending_axis<Dim>] +=
                (load_ - load_before_) *
                chain_.model().straight_moments[static_cast<std::size_t>(j)];
        const core::Vec<Dim, Dual> old_separation = constants(start.separation);
        const core::Vec<Dim, Dual> new_separation = old_separation + motion.velocity;
        motion.separation = old_separation + Dual(0.5) * motion.velocity;

        const physics::BondFrame<Dim, Dual> before(old_separation);
        const physics::BondFrame<Dim, Dual> middle(motion.separation);
        const physics::BondFrame<Dim, Dual> after(new_separation);
        history.shear_force = middle.turned_shear(history.shear_force);
        history.moment = middle.turned_moment(history.moment, before.direction());
        const auto rates = physics::bond_response(bond, chain_.law(), middle, motion, history);
        history.shear_force = after.turned_shear(history.shear_force + rates.rate.shear_force);
        history.moment =
            after.turned_moment(history.moment + rates.rate.moment, middle.direction());

        physics::BondMotion<Dim, Dual> rest{};
        rest.separation = new_separation;
        physics::BondState<Dim, Dual> loaded = history;
        if (!chain_.is_plain())
            loaded.moment = physics::loaded_moment(bending_, {}, bond, after, rest, history.moment,
                                                   extras_at_rest(state, j, history));
        return {history, physics::bond_response(bond, chain_.law(), after, rest, loaded)};
    }

    /// User's moments at the end of the step; Maxwell branches have relaxed.
    [[nodiscard]] physics::BondExtras<Dim, double>
    extras_at_rest(const std::vector<double>& state, int j,
                   const physics::BondState<Dim, Dual>& history) const {
        const auto& layout = chain_.layout();
        const physics::BondMotion<Dim, double> rest{};
        return chain_.bond_extras(
            j, layout.sphere(state.data(), j), layout.sphere(state.data(), j + 1), rest,
            {values_of(history.moment), state.data() + layout.branch_offset(j)}, 0.0, true);
    }

    /// A user's force on sphere `i` at rest; finger and moving support do not act here.
    [[nodiscard]] physics::NodeLoad<Dim, double>
    node_load_at_rest(int i, physics::SphereState<Dim, double> sphere,
                      const std::vector<double>& state) const {
        sphere.velocity = core::Vec<Dim, double>::zero();
        const auto below = i > 0 ? chain_.bond_extras(state.data(), i - 1, 0.0, false)
                                 : physics::BondExtras<Dim, double>{};
        return chain_.user_load(i, sphere, below, 0.0, true);
    }

    /// Out-of-balance forces and their derivatives at the present increment.
    void assemble(const std::vector<double>& state, double to_go) {
        blocks_.set_zero();
        const std::size_t last = blocks_.block_count() - 1;
        for (std::size_t i = 0; i <= last; ++i) {
            residual_[i].setZero();
            add_outer_load(state, i);
        }
        for (std::size_t j = 0; j < last; ++j)
            add_bond(j, evaluate(state, static_cast<int>(j)).response);

        if (chain_.base_turns())
            add_hinge(state);
        for (int row = 0; row < block; ++row) {
            if (chain_.base_turns() && row == Dim + physics::bending_axis<Dim>)
                continue;
            blocks_.diagonal(0).row(row).setZero();
            blocks_.diagonal(0)(row, row) = 1.0;
            blocks_.upper(0).row(row).setZero();
            residual_[0](row) = increment_[0](row);
        }
        blocks_.diagonal(last).row(1).setZero();
        blocks_.lower(last).row(1).setZero();
        blocks_.diagonal(last)(1, 1) = 1.0;
        residual_[last](1) = increment_[last](1) - to_go;
    }

    void add_outer_load(const std::vector<double>& state, std::size_t i) {
        const int sphere = static_cast<int>(i);
        for (int k = 0; k < Dim; ++k)
            residual_[i](k) = load_ * chain_.sphere_inertia(sphere).mass * chain_.gravity()[k];
        if (!lateral_loads_.empty())
            residual_[i](1) += load_ * lateral_loads_[i];
        if (chain_.model().user_laws.empty())
            return;
        auto displaced = chain_.layout().sphere(state.data(), sphere);
        for (int k = 0; k < Dim; ++k)
            displaced.position[k] += increment_[i](k);
        const auto outer = node_load_at_rest(sphere, displaced, state);
        residual_[i](1) += load_ * outer.force[1];
        blocks_.diagonal(i)(1, 1) += load_ * outer.by_deflection;
    }

    /// The clamp's spring. Dry friction is set to zero; at rest it could take any value.
    void add_hinge(const std::vector<double>& state) {
        constexpr int row = Dim + physics::bending_axis<Dim>;
        const double rotation_now =
            state[chain_.layout().base_rotation_offset()] + increment_[0](row);
        const auto turned = first_turn(rotation_now);
        const auto clamp = chain_.clamp_moment({rotation_now, 0.0, turned.moment}, 0.0, true);
        residual_[0](row) += clamp.moment;
        blocks_.diagonal(0)(row, row) += clamp.by_rotation - turned.by_rotation;
    }

    /// Moment of a clamp that slips, and its slope; zeros for another one.
    [[nodiscard]] physics::HingeMoment<double> first_turn(double rotation) const {
        const auto& model = chain_.model();
        return model.slip ? physics::first_turn(*model.hinge, *model.slip, rotation)
                          : physics::HingeMoment<double>{};
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
            histories.push_back({values_of(history.shear_force), values_of(history.moment)});
        }
        for (int i = 0; i < layout.sphere_count(); ++i) {
            auto sphere = layout.sphere(state.data(), i);
            for (int k = 0; k < Dim; ++k)
                sphere.position[k] += increment_[static_cast<std::size_t>(i)](k);
            layout.set_sphere(state.data(), i, sphere);
        }
        for (int j = 0; j < layout.bond_count(); ++j)
            layout.set_bond(state.data(), j, histories[static_cast<std::size_t>(j)]);
        if (layout.base_turns())
            state[layout.base_rotation_offset()] += increment_[0](Dim + physics::bending_axis<Dim>);
        if (layout.base_slips())
            state[layout.base_moment_offset()] =
                first_turn(state[layout.base_rotation_offset()]).moment;
    }

    const physics::Chain<Dim, double>& chain_;
    std::span<const double> lateral_loads_; ///< (spheres), N, or empty
    std::optional<physics::BendingLaw<Dual>> bending_;
    Blocks blocks_;
    std::vector<Column> increment_; ///< displacement (m) and rotation (rad) of each sphere
    std::vector<Column> residual_;
    double load_ = 0.0;        ///< share of gravity and natural curvature at the end of the step
    double load_before_ = 0.0; ///< and at its start
};

/// Sets the moments that remain in the Maxwell branches of a stem that was held for some time.
template <int Dim>
void set_held_branches(const physics::Chain<Dim, double>& chain, std::vector<double>& state) {
    const auto& layout = chain.layout();
    for (int j = 0; j < layout.bond_count(); ++j)
        for (int k = 0; k < layout.branch_count(); ++k) {
            const auto& branch = chain.model().branches[static_cast<std::size_t>(k)];
            const auto moment = layout.bond(state.data(), j).moment;
            layout.set_branch_moment(state.data(), j, k,
                                     (branch.held_share * branch.relative_stiffness) * moment);
        }
}

} // namespace

template <int Dim>
StaticState deflected_equilibrium(const physics::Chain<Dim, double>& chain, double tip_deflection,
                                  std::span<const double> lateral_loads) {
    const auto& layout = chain.layout();
    const double free_length = chain.bond_coefficients().length * layout.bond_count();
    StaticState result{chain.straight_state(), 0.0};
    LoadStep<Dim> step(chain, lateral_loads);

    double fraction = 0.0;
    double stride = 1.0 / (least_load_steps + std::ceil(load_steps_per_slope *
                                                        std::abs(tip_deflection) / free_length));
    int halvings = 0;
    while (fraction < 1.0) {
        const double next = fraction + stride > 1.0 - 1e-9 ? 1.0 : fraction + stride;
        if (step.advance(result.state, next * tip_deflection, next)) {
            fraction = next;
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
    set_held_branches(chain, result.state);
    return result;
}

template StaticState deflected_equilibrium<2>(const physics::Chain<2, double>&, double,
                                              std::span<const double>);
template StaticState deflected_equilibrium<3>(const physics::Chain<3, double>&, double,
                                              std::span<const double>);

} // namespace culm::integrate
