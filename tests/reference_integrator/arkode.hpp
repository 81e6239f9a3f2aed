// SPDX-License-Identifier: BSD-3-Clause
// Implicit integration of a chain by SUNDIALS' ARKODE: the independent check of culm's integrator.
#pragma once

#include "integrate/error_scales.hpp"
#include "integrate/implicit.hpp"

#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace culm::integrate {

struct ArkodeOptions {
    /// Error of displacements and velocities allowed per step, relative to their scales.
    double relative_tolerance = 1e-6;
    /// Weight of the errors of spins and bond histories beside those of displacements and
    /// velocities.
    double bond_error_weight = 1e-4;
    std::int64_t step_limit = 2'000'000;
    /// Number of another of ARKODE's DIRK tables instead of ARK436L2SA.
    std::optional<int> butcher_table;
    Heartbeat heartbeat;
};

/// The same problem as integrate_implicit(), by ARKODE's DIRK methods with the chain's exact,
/// condensed Jacobian. Throws core::NumericalError (StepLimit, SolverFailed) or Interrupted.
template <int Dim>
SolveSummary integrate_arkode(const physics::Chain<Dim, double>& chain, std::vector<double>& state,
                              const ErrorScales& scales, double duration,
                              const StepObserver& observe, const ArkodeOptions& options);

} // namespace culm::integrate
