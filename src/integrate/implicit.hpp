// SPDX-License-Identifier: BSD-3-Clause
// Implicit integration of chains: the stiffness of the bonds' damping does not limit the step.
#pragma once

#include "core/error.hpp"
#include "core/lanes.hpp"
#include "integrate/error_weights.hpp"
#include "integrate/solve_summary.hpp"
#include "physics/chain.hpp"

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace culm::integrate {

struct ImplicitOptions {
    /// Allowed error of the positions per step: the root mean square over the chain, relative to
    /// the displacement's scale.
    double relative_tolerance = 2e-6;
    /// Weight of the errors of velocities, spins and bond histories, each relative to its scale.
    /// The weight of the positions is 1. High modes that no camera sees dominate these errors: with
    /// a weight above 0 a run needs several times more steps for the same deflections. Set 1 for an
    /// accurate energy balance.
    double rate_error_weight = 0.0;
    /// If > 0: every step has this length (s), without error control; for convergence studies.
    double fixed_step = 0.0;
    /// All lanes take the steps of lane 0 (Rosenbrock::follow_first_lane).
    bool follow_first_lane = false;
    std::int64_t step_limit = 2'000'000;
    Heartbeat heartbeat;
};

/// One accepted step: time (s) and state at its end, in the chain's layout.
using StepObserver = std::function<void(double time, std::span<const double> state)>;

/// How one lane's integration ended.
struct LaneOutcome {
    SolveSummary work;
    std::optional<core::NumericalError> failure;
};

/// An accepted step of one lane; `state` holds all lanes, of which only `lane` is at `time`.
template <class T>
using LaneObserver = std::function<void(std::size_t lane, double time, std::span<const T> state)>;

/// Integrates one stem per lane from t = 0, each with its own steps and to its own duration, s.
/// Calls `observe` at t = 0 and after every step; the last step ends at or beyond the duration.
/// Lanes do not influence one another: a lane that fails stops and reports (StepLimit,
/// SolverFailed), and the others continue. Each result is bit for bit independent of the other
/// lanes. Throws only Interrupted.
template <int Dim, class T>
std::array<LaneOutcome, core::lanes_of<T>>
integrate_lanes(const physics::Chain<Dim, T>& chain, const std::vector<T>& released,
                const ErrorScalesOf<T>& scales,
                const std::array<double, core::lanes_of<T>>& durations,
                const LaneObserver<T>& observe, const ImplicitOptions& options);

} // namespace culm::integrate
