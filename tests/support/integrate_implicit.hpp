// SPDX-License-Identifier: BSD-3-Clause
// The implicit integration of one stem, with failures as exceptions.
#pragma once

#include "integrate/implicit.hpp"

#include <span>
#include <vector>

namespace culm::integrate {

/// Integrates from t = 0 to `duration`; `state` becomes the last state. Calls `observe` at t = 0
/// and after every step; the last step ends at or beyond `duration`.
/// Throws core::NumericalError (StepLimit, SolverFailed) or Interrupted.
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

} // namespace culm::integrate
