// SPDX-License-Identifier: BSD-3-Clause
// One least-squares solution by Ceres over given windows of the recordings.
#pragma once

#include "calibrate/joint_fit.hpp"

#include <limits>
#include <vector>

namespace culm::calibrate {

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
    JointProblem(std::span<const measure::Measurement> measurements, const JointLayout& layout,
                 const std::vector<std::vector<double>>& noise, const std::vector<bool>& is_held,
                 const ChainFitOptions& options);

    /// Frames up to `last_times` (recordings), from the models' values. Throws
    /// core::NumericalError if a chain cannot be computed at the end.
    [[nodiscard]] JointSolution solve(const std::vector<StemModel>& models,
                                      const std::vector<double>& last_times, Purpose purpose) const;

  private:
    std::span<const measure::Measurement> measurements_;
    const JointLayout& layout_;
    const std::vector<std::vector<double>>& noise_;
    const std::vector<bool>& is_held_;
    const ChainFitOptions& options_;
};

} // namespace culm::calibrate
