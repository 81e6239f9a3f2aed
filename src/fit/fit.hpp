// SPDX-License-Identifier: BSD-3-Clause
// Fits a model to every height and frame of one or several recordings at once (the mathematics:
// fit_result.hpp).
#pragma once

#include "fit/solve/fit_result.hpp"

#include <span>
#include <vector>

namespace culm::fit {

struct JointOptions : FitOptions {
    bool is_held = false; ///< all numbers keep their values
    /// (recordings)(rows), m: divides the residuals of recordings whose noise is not known; empty:
    /// the same value for all.
    std::vector<std::vector<double>> noise{};
    std::vector<KnownPoint> known{}; ///< (recordings) at the models' values; empty: to be computed
    std::vector<StartModels> other_starts{}; ///< the best of all starts counts
    /// A chain that does not follow the motion, in a record that begins long after time 0, fails.
    bool is_first_guess = false;
};

/// Fits all recordings by least squares (solution.hpp) with the sensitivities of
/// run::simulate_with_sensitivities. Each recording has its own model (length, section, known
/// masses, frame rate, rows). The fit starts from the models' values, for a shared parameter from
/// the first model that has it. A fit that does not converge is Failed; one that ends at a bound
/// has that as its reason. Throws core::NumericalError if it cannot start, run::Abandoned if the
/// heartbeat says so.
[[nodiscard]] Fit fit_jointly(std::span<const StemModel> models,
                              std::span<const ObservedRecording> measurements,
                              JointOptions options = {});

} // namespace culm::fit
