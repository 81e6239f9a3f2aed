// SPDX-License-Identifier: BSD-3-Clause
// One least-squares solution over given windows of the recordings.
//
// Gauss-Newton steps on the weighted system, in the coordinates of the parameters and within their
// bounds. A full step is tried first. If it fails, damped steps (Levenberg and Marquardt) and then
// paths along the curvature of the best of them are computed side by side in lanes, and the best
// end is taken.
//
// The solution ends where the next step promises, or the last one gained, less than 0.1 of what one
// standard error of a parameter changes.
//
// A ring-down determines the stem's frequency to 1e-4, and many parameters change it: a mass at the
// tip, a soft clamp, a taper. The valley in which Y compensates for them is narrow and curved:
// readings of N cycles lose their phase after a change of f by 1/N, and a straight step along the
// floor leaves it. So every step takes the values of Y and β at which the linearised chain has the
// frequency and the decay of the straight step to first order: f² is proportional to Y except for
// the share of the other parameters, and ln f² is corrected by changes of ln Y; decay is linear in
// β.
//
// Trap: the integrator's choice of steps depends on the parameters, which adds noise of 0.2 to χ².
// A step that fails by less has met the noise, not a wrong model. Derivatives by lanes have errors
// of 1e-5: along a valley, where large columns cancel, they promise gains that do not exist.
#pragma once

#include "fit/chain/prediction.hpp"
#include "fit/linear/weighted_system.hpp"

#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace culm::fit {

/// One model for each recording.
using StartModels = std::vector<StemModel>;

struct FitOptions {
    ChainOptions chain;
    /// Only frames up to here, s after each recording's release; empty: all. Frames before the
    /// release are used.
    std::optional<double> window;
    run::Heartbeat heartbeat;
    bool with_inputs = true;  ///< the linear solution has terms of stated inputs and second mode
    bool moves_inputs = true; ///< inputs that the readings contradict are moved by runs
    int largest_iterations = 50;
    /// Names of effects whose numbers keep their values; the system has their derivatives.
    std::vector<std::string> held_effects;
};

/// `options` with this heartbeat, or unchanged if it is empty.
[[nodiscard]] FitOptions with_heartbeat(FitOptions options, const run::Heartbeat& heartbeat);

struct JointSolution {
    StartModels models;
    std::vector<ChainPrediction> predictions;
    std::vector<std::vector<double>> times;                ///< (recordings)(frames), s
    int batches = 0;                                       ///< of the chain: batches of lanes
    double cost = std::numeric_limits<double>::infinity(); ///< sum of squares
    bool has_converged = false;
    std::string message;
};

/// The readings of some recordings and their weights.
struct JointProblem {
    std::span<const ObservedRecording> measurements;
    const JointLayout& layout;
    const std::vector<std::vector<double>>& noise; ///< (recordings)(rows), m
    const std::vector<bool>& is_held;              ///< (joint parameters)
    const FitOptions& options;
};

/// Predicted readings of several runs, each with one model for each recording, (runs)(recordings).
/// The runs are computed side by side in lanes, whose number is added to `batches`. `times`:
/// (recordings), s. Throws as predict_readings().
[[nodiscard]] std::vector<std::vector<ChainPrediction>>
predict_runs(const std::vector<StartModels>& runs, std::span<const std::vector<double>> times,
             const run::Heartbeat& heartbeat, int& batches);

/// Lowest and highest changes of the joint parameters' coordinates.
[[nodiscard]] std::pair<Eigen::VectorXd, Eigen::VectorXd> bounds_of(const StartModels& models,
                                                                    const JointLayout& layout);

/// Solves from the best of the starts, which are run side by side. The last start is safe: another
/// one may have a larger residual and still be nearer to the solution, but not if its χ² is ten
/// times as large. The `predictions` are those of a single start; empty: to be computed. Throws
/// core::NumericalError if a chain cannot be computed at the start.
[[nodiscard]] JointSolution solve(const JointProblem& problem,
                                  const std::vector<StartModels>& starts,
                                  std::vector<ChainPrediction> predictions = {});

/// The models after this change of the joint parameters' coordinates, each within its bounds.
[[nodiscard]] StartModels moved(StartModels models, const JointLayout& layout,
                                const Eigen::VectorXd& change);

/// The models at the end of a change. `at`: the models at a share of it. Y and β are corrected such
/// that frequency and decay of the first mode are those of the straight change to first order.
[[nodiscard]] StartModels in_valley(const std::function<StartModels(double)>& at,
                                    const JointLayout& layout);

} // namespace culm::fit
