// SPDX-License-Identifier: BSD-3-Clause
// One least-squares solution by Ceres over given windows of the recordings.
#pragma once

#include "fit/model/prediction.hpp"
#include "fit/solve/layout.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include <ceres/iteration_callback.h>

namespace culm::fit {

/// Ends a solution that slows down and could not come down to `wanted` within its iterations even
/// at the best pace of its last ones. One that gains speed goes on: steps begin short and triple.
class OutOfReach : public ceres::IterationCallback {
  public:
    OutOfReach(double wanted, int largest_iterations)
        : wanted_(wanted), largest_iterations_(largest_iterations) {}
    [[nodiscard]] bool is_so() const { return is_so_; }
    ceres::CallbackReturnType operator()(const ceres::IterationSummary& iteration) override {
        const auto slot = static_cast<std::size_t>(iteration.iteration) % gains_.size();
        gains_[slot] = iteration.step_is_successful ? iteration.cost_change : 0.0;
        if (iteration.iteration < static_cast<int>(gains_.size()))
            return ceres::SOLVER_CONTINUE;
        const double left = largest_iterations_ - iteration.iteration;
        const double best = *std::ranges::max_element(gains_);
        const double before = gains_[(slot + gains_.size() - 1) % gains_.size()];
        const bool slows_down = std::max(gains_[slot], before) <= 0.5 * best;
        // Of a step that failed, `cost` is where it would have led.
        const double cost =
            iteration.cost + (iteration.step_is_successful ? 0.0 : iteration.cost_change);
        is_so_ = slows_down && cost - left * best > wanted_;
        return is_so_ ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
    }

  private:
    double wanted_; ///< as Ceres counts the cost
    int largest_iterations_;
    std::array<double, 5> gains_{}; ///< of the last iterations
    bool is_so_ = false;
};

struct SolveOptions {
    /// Only frames up to here, s after the release; empty: all. Frames before the release count.
    std::optional<double> window;
    /// True: from the model's values as a first guess, with several moduli about it and a window
    /// that grows from 2 to 5 and 12 cycles to all, so that no cycle is skipped. False: the values
    /// are near the solution (a refit with an effect added), all frames at once.
    bool is_first_guess = true;
    int largest_iterations = 50; ///< of each window
    /// A solution whose pace would not bring χ² down to this within the iterations ends early, as
    /// Fit::out_of_reach says; empty: none does.
    std::optional<double> wanted_chi_squared;
    run::Heartbeat heartbeat;
};

struct JointSolution {
    std::vector<StemModel> models;
    std::vector<ChainPrediction> predictions;
    std::vector<std::vector<double>> times;                ///< (recordings)(frames), s
    std::vector<int> runs;                                 ///< (recordings)
    double cost = std::numeric_limits<double>::infinity(); ///< as Ceres minimises it
    bool has_converged = false;
    bool is_cut_short = false; ///< what was wanted is out of reach
    std::string message;
};

/// When a solution is good enough.
enum class Purpose {
    Final,  ///< to a small part of what one standard error changes
    Passing ///< only to lead to a longer window
};

/// The readings of some recordings and by what they are weighted.
class JointProblem {
  public:
    /// All must outlive this; `noise` (recordings)(rows), m; `is_held` (joint parameters).
    JointProblem(std::span<const ObservedRecording> measurements, const JointLayout& layout,
                 const std::vector<std::vector<double>>& noise, const std::vector<bool>& is_held,
                 const SolveOptions& options);

    /// Frames up to `last_times` (recordings), from the models' values. Throws
    /// core::NumericalError if a chain cannot be computed at the end.
    [[nodiscard]] JointSolution solve(const std::vector<StemModel>& models,
                                      const std::vector<double>& last_times, Purpose purpose) const;

  private:
    std::span<const ObservedRecording> measurements_;
    const JointLayout& layout_;
    const std::vector<std::vector<double>>& noise_;
    const std::vector<bool>& is_held_;
    const SolveOptions& options_;
};

} // namespace culm::fit
