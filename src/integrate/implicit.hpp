// SPDX-License-Identifier: BSD-3-Clause
// Implicit integration of a chain: steps over the stiffness that the bonds' damping causes.
#pragma once

#include "integrate/solve_summary.hpp"
#include "physics/chain.hpp"

#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace culm::integrate {

struct ImplicitOptions {
    /// Error of displacements and velocities allowed per step, relative to their scales.
    double relative_tolerance = 1e-6;
    /// Weight of the errors of spins and bond histories beside those of displacements and
    /// velocities. High modes that the camera never sees dominate them; at equal weight a run takes
    /// several times more steps for the same history. Set 1 to account for energy.
    double bond_error_weight = 1e-4;
    /// > 0: every step has this length (s) and errors are not controlled; for convergence studies.
    double fixed_step = 0.0;
    std::int64_t step_limit = 2'000'000;
    /// Number of another of ARKODE's DIRK tables instead of the chosen one; for bench/.
    std::optional<int> butcher_table;
    Heartbeat heartbeat;
};

/// Sizes of displacement, velocity, spin, shear force and moment against which errors are weighed.
struct ErrorScales {
    double displacement; ///< m
    double velocity;     ///< m/s
    double spin;         ///< rad/s
    double shear_force;  ///< N
    double moment;       ///< N m
};

/// Scales of a clamped stem that is released from a tip deflection: the deflection itself, and with
/// Euler-Bernoulli's first mode its velocity, spin, tip force and root moment.
[[nodiscard]] ErrorScales cantilever_scales(const physics::StemParameters<double>& stem,
                                            double tip_deflection);

/// One accepted step: time (s) and state at its end, in the chain's layout.
using StepObserver = std::function<void(double time, std::span<const double> state)>;

/// Integrates from t = 0 to `duration`, at the end of which `state` is the last state; calls
/// `observe` at t = 0 and after every step, the last one ending at or beyond `duration`.
/// Throws core::NumericalError (StepLimit, SolverFailed, NotANumber) or Interrupted.
template <int Dim>
SolveSummary integrate_implicit(const physics::Chain<Dim, double>& chain,
                                std::vector<double>& state, const ErrorScales& scales,
                                double duration, const StepObserver& observe,
                                const ImplicitOptions& options);

} // namespace culm::integrate
