// SPDX-License-Identifier: BSD-3-Clause
#include "integrate/implicit.hpp"

#include "integrate/rosenbrock.hpp"

#include <algorithm>

#include <fmt/core.h>

namespace culm::integrate {
namespace {

/// Which lanes are running, and how the others ended.
template <int Dim, class T>
class LaneProgress {
    static constexpr std::size_t lanes = core::lanes_of<T>;

  public:
    LaneProgress(const std::array<double, lanes>& durations, std::int64_t step_limit)
        : durations_(durations), step_limit_(step_limit) {
        for (std::size_t lane = 0; lane < lanes; ++lane)
            runs_[lane] = durations[lane] > 0.0;
    }

    [[nodiscard]] const std::array<bool, lanes>& running() const { return runs_; }
    [[nodiscard]] bool any_runs() const {
        return std::any_of(runs_.begin(), runs_.end(), [](bool lane) { return lane; });
    }

    /// Records the progress of lane `lane`.
    void update(std::size_t lane, const StepController& controller) {
        const std::int64_t steps = controller.accepted_steps();
        const std::int64_t attempts = steps + controller.rejected_steps();
        outcomes_[lane].work = work_of(attempts, steps);
        if (controller.time() >= durations_[lane]) {
            runs_[lane] = false;
        } else if (controller.has_failed()) {
            fail(lane, core::FailureKind::SolverFailed,
                 fmt::format("no step of the implicit solver is short enough at t = {:.6g} s",
                             controller.time()));
        } else if (steps >= step_limit_) {
            fail(lane, core::FailureKind::StepLimit,
                 fmt::format("the implicit solver used up its {} steps at t = {:.6g} s", steps,
                             controller.time()));
        }
    }

    [[nodiscard]] std::array<LaneOutcome, lanes> outcomes() const { return outcomes_; }

  private:
    [[nodiscard]] static SolveSummary work_of(std::int64_t attempts, std::int64_t steps) {
        // A Rosenbrock method has no iteration: each attempt costs one factorisation, and for each
        // stage one force evaluation and one solve. A rejected attempt keeps its Jacobian.
        constexpr std::int64_t stages = Rodas5::stages;
        SolveSummary work;
        work.steps = steps;
        work.rejected_steps = attempts - steps;
        work.rhs_evaluations = stages * attempts;
        work.jacobian_evaluations = steps;
        work.factorisations = attempts;
        work.linear_solves = stages * attempts;
        return work;
    }
    void fail(std::size_t lane, core::FailureKind kind, const std::string& reason) {
        runs_[lane] = false;
        outcomes_[lane].failure = core::NumericalError(kind, reason);
    }

    std::array<double, lanes> durations_;
    std::int64_t step_limit_;
    std::array<bool, lanes> runs_{};
    std::array<LaneOutcome, lanes> outcomes_{};
};

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
    LaneProgress<Dim, T> progress(durations, options.step_limit);
    for (std::size_t lane = 0; lane < lanes; ++lane)
        observe(lane, 0.0, rosenbrock.state());

    // Every lane has its own step length. A lane that has ended is still computed, but not
    // recorded. Therefore the results of a stem do not depend on the other lanes.
    while (progress.any_runs()) {
        const std::array<bool, lanes> tried = progress.running();
        const std::array<bool, lanes> accepted = rosenbrock.try_step(tried);
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            if (!tried[lane])
                continue;
            if (accepted[lane])
                observe(lane, rosenbrock.controller(lane).time(), rosenbrock.state());
            progress.update(lane, rosenbrock.controller(lane));
        }
        if (options.heartbeat && !options.heartbeat())
            throw Interrupted{};
    }
    return progress.outcomes();
}

template <int Dim>
SolveSummary integrate_implicit(const physics::Chain<Dim, double>& chain,
                                std::vector<double>& state, const ErrorScales& scales,
                                double duration, const StepObserver& observe,
                                const ImplicitOptions& options) {
    const std::vector<double> released = state;
    const auto outcome = integrate_lanes<Dim, double>(
                             chain, released, scales, {duration},
                             [&](std::size_t, double time, std::span<const double> at) {
                                 observe(time, at);
                                 state.assign(at.begin(), at.end());
                             },
                             options)
                             .front();
    if (outcome.failure)
        throw *outcome.failure;
    return outcome.work;
}

template SolveSummary integrate_implicit<2>(const physics::Chain<2, double>&, std::vector<double>&,
                                            const ErrorScales&, double, const StepObserver&,
                                            const ImplicitOptions&);
template SolveSummary integrate_implicit<3>(const physics::Chain<3, double>&, std::vector<double>&,
                                            const ErrorScales&, double, const StepObserver&,
                                            const ImplicitOptions&);

template std::array<LaneOutcome, core::lane_count>
integrate_lanes<2, core::Lanes>(const physics::Chain<2, core::Lanes>&,
                                const std::vector<core::Lanes>&, const ErrorScalesOf<core::Lanes>&,
                                const std::array<double, core::lane_count>&,
                                const LaneObserver<core::Lanes>&, const ImplicitOptions&);
template std::array<LaneOutcome, core::lane_count>
integrate_lanes<3, core::Lanes>(const physics::Chain<3, core::Lanes>&,
                                const std::vector<core::Lanes>&, const ErrorScalesOf<core::Lanes>&,
                                const std::array<double, core::lane_count>&,
                                const LaneObserver<core::Lanes>&, const ImplicitOptions&);

} // namespace culm::integrate
