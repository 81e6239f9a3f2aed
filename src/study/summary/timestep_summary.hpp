// SPDX-License-Identifier: BSD-3-Clause
// Results of a time-step study: limits, their laws, and the errors of the steps below them.
#pragma once

#include "reduce/timestep_regression.hpp"
#include "study/execute/point_results.hpp"
#include "study/summary/summary.hpp"

#include <cstdint>
#include <vector>

namespace culm::study {

/// b1 and b2 of one stem at one step. Errors are (at this step − converged)/converged; NaN where
/// there is no fit or no converged value.
struct StepResult {
    double step = 0.0; ///< s
    StepOutcome outcome = StepOutcome::NoFit;
    double decay_per_cycle = 0.0;
    double frequency = 0.0; ///< Hz
    double decay_error = 0.0;
    double frequency_error = 0.0;
    double predicted_decay_error = 0.0;     ///< of the linearised first mode
    double predicted_frequency_error = 0.0; ///< of the linearised first mode
};

/// One completed point.
struct TimestepStem {
    std::int64_t point = 0;
    double youngs_modulus = 0.0; ///< Pa
    double bond_damping = 0.0;
    double stable = 0.0;              ///< bisected, s
    double unstable = 0.0;            ///< bisected, s
    double transverse = 0.0;          ///< linearised, s
    double axial = 0.0;               ///< linearised, s
    double rule = 0.0;                ///< the authors', s
    double bond_time = 0.0;           ///< √(m/k_n), s
    double reference_decay = 0.0;     ///< b1 per cycle of the implicit run
    double reference_frequency = 0.0; ///< b2 of the implicit run, Hz
    double converged_decay = 0.0;     ///< b1 per cycle for steps towards zero
    double converged_frequency = 0.0; ///< b2 for steps towards zero, Hz
    std::vector<StepResult> steps;    ///< one per fraction

    [[nodiscard]] double limit() const { return 0.5 * (stable + unstable); }
    [[nodiscard]] double linearised() const { return transverse < axial ? transverse : axial; }
};

struct TimestepSummary {
    std::int64_t points = 0;
    std::vector<TimestepStem> stems; ///< the completed points
    std::vector<FailedPoint> failed;
    std::vector<std::int64_t> missing; ///< points that were not computed (a merged archive)
    int ranks = 1;
    double wall_s = 0.0;
    TimestepOptions options;
    reduce::TimestepRegression regression; ///< of the bisected limits
};

/// The value at step zero of the parabola (of the line) through the values at the three (two)
/// smallest steps: Richardson's extrapolation. NaN for fewer than two. Pairs with a value that is
/// not finite are ignored.
[[nodiscard]] double extrapolated_to_zero(const std::vector<double>& steps,
                                          const std::vector<double>& values);

/// Reduces the archive of a time-step study. Throws core::InputError for another kind of study.
[[nodiscard]] TimestepSummary reduce_timestep_study(const ArchivedStudy& archived);

} // namespace culm::study
