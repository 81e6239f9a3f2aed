// SPDX-License-Identifier: BSD-3-Clause
// One least-squares solution by Ceres over given windows of the recordings.
#pragma once

#include "fit/model/prediction.hpp"
#include "fit/solve/layout.hpp"

#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace culm::fit {

struct SolveOptions {
    /// Only frames up to here, s after the release; empty: all. Frames before the release are used.
    std::optional<double> window;
    /// True: starts from a first guess, with several moduli about it and a window that grows from 2
    /// to 5 and 12 cycles to all, so that no cycle is skipped. False: the values are near the
    /// solution (a refit with an effect added), and all frames are used at once.
    bool is_first_guess = true;
    int largest_iterations = 50; ///< of each window
    run::Heartbeat heartbeat;
};

struct JointSolution {
    std::vector<StemModel> models;
    std::vector<ChainPrediction> predictions;
    std::vector<std::vector<double>> times;                ///< (recordings)(frames), s
    std::vector<int> runs;                                 ///< (recordings)
    double cost = std::numeric_limits<double>::infinity(); ///< as Ceres minimises it
    bool has_converged = false;
    std::string message;
};

/// Determines when a solution is good enough.
enum class Purpose {
    Final,  ///< to a small part of what one standard error changes
    Passing ///< only to lead to a longer window
};

/// The readings of some recordings and their weights.
struct JointProblem {
    std::span<const ObservedRecording> measurements;
    const JointLayout& layout;
    const std::vector<std::vector<double>>& noise; ///< (recordings)(rows), m
    const std::vector<bool>& is_held;              ///< (joint parameters)
    const SolveOptions& options;
};

/// Solves for frames up to `last_times` (recordings), from the models' values. Throws
/// core::NumericalError if a chain cannot be computed at the end.
[[nodiscard]] JointSolution solve(const JointProblem& problem, const std::vector<StemModel>& models,
                                  const std::vector<double>& last_times, Purpose purpose);

} // namespace culm::fit
