// SPDX-License-Identifier: BSD-3-Clause
// The cost of an integration, and the hook by which its caller can stop it.
#pragma once

#include <cstdint>
#include <functional>

namespace culm::integrate {

/// Work done by an integrator.
struct SolveSummary {
    std::int64_t steps = 0;
    std::int64_t rejected_steps = 0; ///< by the error test
    std::int64_t rhs_evaluations = 0;
    std::int64_t linear_solves = 0; ///< with SUNDIALS one for each Newton iteration
    std::int64_t jacobian_evaluations = 0;
    std::int64_t factorisations = 0;
    std::int64_t convergence_failures = 0; ///< steps for which Newton's iteration did not converge
};

/// Called every millisecond or so of work; returning false asks the integrator to give up (it
/// throws Interrupted).
using Heartbeat = std::function<bool()>;

/// The caller's heartbeat asked for a stop.
struct Interrupted {};

} // namespace culm::integrate
