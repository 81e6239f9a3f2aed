// SPDX-License-Identifier: BSD-3-Clause
#include "integrate/implicit.hpp"

#include "integrate/rosenbrock.hpp"

#include <algorithm>

#include <fmt/core.h>

namespace culm::integrate {
namespace {

/// The work of a Rosenbrock method, which has no iteration: each attempt costs one factorisation,
/// and for each stage one force evaluation and one solve. A rejected attempt keeps its Jacobian.
SolveSummary work_of(const StepController& controller) {
    constexpr std::int64_t stages = Rodas5::stages;
    const std::int64_t attempts = controller.accepted_steps() + controller.rejected_steps();
    return {.steps = controller.accepted_steps(),
            .rejected_steps = controller.rejected_steps(),
            .rhs_evaluations = stages * attempts,
            .linear_solves = stages * attempts,
            .jacobian_evaluations = controller.accepted_steps(),
            .factorisations = attempts};
}

/// Why a lane cannot reach its end, if so.
std::optional<core::NumericalError> failure_of(const StepController& controller,
                                               std::int64_t step_limit) {
    if (controller.has_failed())
        return core::NumericalError(
            core::FailureKind::SolverFailed,
            fmt::format("no step of the implicit solver is short enough at t = {:.6g} s",
                        controller.time()));
    if (controller.accepted_steps() >= step_limit)
        return core::NumericalError(
            core::FailureKind::StepLimit,
            fmt::format("the implicit solver used up its {} steps at t = {:.6g} s",
                        controller.accepted_steps(), controller.time()));
    return std::nullopt;
}

} // namespace

template <int Dim, class T>
std::array<LaneOutcome, core::lanes_of<T>>
integrate_lanes(const physics::Chain<Dim, T>& chain, const std::vector<T>& released,
                const ErrorScalesOf<T>& scales,
                const std::array<double, core::lanes_of<T>>& durations,
                const LaneObserver<T>& observe, const ImplicitOptions& options) {
    constexpr std::size_t lanes = core::lanes_of<T>;
    Rosenbrock<Dim, T> rosenbrock(chain, released, scales, options.relative_tolerance,
                                  options.rate_error_weight);
    if (options.fixed_step > 0.0)
        rosenbrock.fix_step(options.fixed_step);
    if (options.follow_first_lane)
        rosenbrock.follow_first_lane();
    std::array<bool, lanes> runs{};
    std::array<LaneOutcome, lanes> outcomes{};
    for (std::size_t lane = 0; lane < lanes; ++lane) {
        runs[lane] = durations[lane] > 0.0;
        observe(lane, 0.0, rosenbrock.state());
    }
    // Every lane has its own step length. A lane that has ended is still computed, but not
    // recorded. Therefore the results of a stem do not depend on the other lanes.
    while (std::ranges::find(runs, true) != runs.end()) {
        const std::array<bool, lanes> accepted = rosenbrock.try_step(runs);
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            if (!runs[lane])
                continue;
            const StepController& controller = rosenbrock.controller(lane);
            if (accepted[lane])
                observe(lane, controller.time(), rosenbrock.state());
            outcomes[lane].work = work_of(controller);
            const bool is_done = controller.time() >= durations[lane];
            if (!is_done)
                outcomes[lane].failure = failure_of(controller, options.step_limit);
            runs[lane] = !is_done && !outcomes[lane].failure;
        }
        if (options.heartbeat && !options.heartbeat())
            throw Interrupted{};
    }
    return outcomes;
}

template std::array<LaneOutcome, core::lanes_of<double>>
integrate_lanes(const physics::Chain<2, double>&, const std::vector<double>&,
                const ErrorScalesOf<double>&, const std::array<double, core::lanes_of<double>>&,
                const LaneObserver<double>&, const ImplicitOptions&);
template std::array<LaneOutcome, core::lanes_of<double>>
integrate_lanes(const physics::Chain<3, double>&, const std::vector<double>&,
                const ErrorScalesOf<double>&, const std::array<double, core::lanes_of<double>>&,
                const LaneObserver<double>&, const ImplicitOptions&);
template std::array<LaneOutcome, core::lanes_of<core::Lanes>>
integrate_lanes(const physics::Chain<2, core::Lanes>&, const std::vector<core::Lanes>&,
                const ErrorScalesOf<core::Lanes>&,
                const std::array<double, core::lanes_of<core::Lanes>>&,
                const LaneObserver<core::Lanes>&, const ImplicitOptions&);
template std::array<LaneOutcome, core::lanes_of<core::Lanes>>
integrate_lanes(const physics::Chain<3, core::Lanes>&, const std::vector<core::Lanes>&,
                const ErrorScalesOf<core::Lanes>&,
                const std::array<double, core::lanes_of<core::Lanes>>&,
                const LaneObserver<core::Lanes>&, const ImplicitOptions&);

} // namespace culm::integrate
