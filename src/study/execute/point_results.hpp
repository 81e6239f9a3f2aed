// SPDX-License-Identifier: BSD-3-Clause
// Results that a study stores for each point: the columns of its result table.
#pragma once

#include "archive/point_record.hpp"
#include "archive/study/description.hpp"
#include "reduce/ring_down/ring_down_fit.hpp"
#include "run/case_spec.hpp"
#include "run/simulate.hpp"
#include "study/config/study_config.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace culm::study {

/// The result columns of a study of this kind, in the order of PointRecord::values.
[[nodiscard]] std::vector<archive::Column> result_columns(const StudyConfig& config);

/// The options of the fit that a study asks for.
[[nodiscard]] reduce::RingDownOptions fit_options(const ReduceOptions& options);

/// Sample times of a study's histories, s.
[[nodiscard]] std::vector<double> sample_times(const run::CaseSpec& spec);

/// The record of a point without an answer; `kind` is the short name of the failure.
[[nodiscard]] archive::PointRecord failed_record(std::int64_t point, std::string_view kind,
                                                 const std::string& reason);

/// Fits Eq. 1 to the tip's history and keeps what the study stores. A computed case whose history
/// cannot be fitted fails when nothing but the fit is stored; else its histories are kept and the
/// fit's columns are NaN. `wall_seconds` of the case is not recorded: it differs between runs.
[[nodiscard]] archive::PointRecord make_record(const run::CaseSpec& spec, run::CaseOutcome outcome,
                                               const ReduceOptions& options);

/// Names of the result columns that count an integrator's work, first of all "steps".
[[nodiscard]] std::vector<std::string> work_columns(const StudyConfig& config);

/// Outcome of the run at one step; the value in the archive.
enum class StepOutcome { Fitted = 0, Unstable = 1, NoFit = 2 };

/// Name of a column that belongs to a fraction, for example "frequency_at_0.5".
[[nodiscard]] std::string column_at(std::string_view quantity, double fraction);

/// Computes one point; the config must be of kind Timestep. The point fails if there is no static
/// equilibrium or no limit is found; a step without a fit leaves NaN and its StepOutcome.
/// Throws run::Abandoned.
[[nodiscard]] archive::PointRecord compute_timestep_point(const StudyConfig& config,
                                                          const run::CaseSpec& spec,
                                                          const run::Heartbeat& heartbeat,
                                                          run::Simulator& simulator);

/// Explicit steps that such a point will take, all lanes side by side counting as one; about.
[[nodiscard]] double explicit_steps_of_point(const StudyConfig& config, const run::CaseSpec& spec);

} // namespace culm::study
