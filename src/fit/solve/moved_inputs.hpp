// SPDX-License-Identifier: BSD-3-Clause
// The linear solution about a fit where the readings contradict stated inputs.
//
// The solution is exact for small changes. Beside a misfit it moves inputs by many standard
// uncertainties and promises gains that no chain of that geometry has. If it moves an input of
// the chain by more than `contradiction`, chains at shares of that change are run side by side in
// lanes, and the best one counts: every gain was run. A model that may be adequate deserves more.
// While the best chain falls short of the promise, the columns are computed again about it, and the
// solution there is tried in the same way.
#pragma once

#include "fit/solve/fit_result.hpp"

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace culm::fit {

/// Change of all columns of a system to its minimum within the bounds of the models; `change`
/// happened before.
using LinearSolver = std::function<Eigen::VectorXd(
    const WeightedSystem& system, const StartModels& models, const Eigen::VectorXd& change)>;

struct MovedInputs {
    StartModels models;     ///< with the moved geometry
    Eigen::VectorXd change; ///< (columns of the fit's system) since the fit
    Eigen::VectorXd left;   ///< (rows) of the residual; for a term its negative value
    std::vector<std::vector<double>> readings; ///< (recordings)(frames, rows), with all terms, m
};

/// Empty if the `change` that the solution makes moves no input of a chain so far. The columns are
/// computed again `most_passes` times at most. Adds the lanes that were run to the fit's batches.
[[nodiscard]] std::optional<MovedInputs> moved_inputs(std::span<const ObservedRecording> recordings,
                                                      const JointLayout& layout,
                                                      const Eigen::VectorXd& change,
                                                      const LinearSolver& solve, int most_passes,
                                                      const run::Heartbeat& heartbeat, Fit& fit);

} // namespace culm::fit
