// SPDX-License-Identifier: BSD-3-Clause
// One point of a time-step study: the limits of the explicit step, and b1 and b2 at smaller steps.
#pragma once

#include "archive/point_record.hpp"
#include "archive/study/description.hpp"
#include "run/simulate.hpp"
#include "study/config.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace culm::study {

/// What became of the run at one step; the number in the archive.
enum class StepOutcome { Fitted = 0, Unstable = 1, NoFit = 2 };

/// The result columns, in the order of PointRecord::values; a group of them for each fraction.
[[nodiscard]] std::vector<archive::Column> timestep_columns(const TimestepOptions& options);

/// Name of a column that belongs to a fraction, for example "frequency_at_0.5".
[[nodiscard]] std::string column_at(std::string_view quantity, double fraction);

/// Computes one point; the config must be of kind Timestep. The point fails if there is no static
/// equilibrium or no limit is found; a step without a fit leaves NaN and its StepOutcome.
/// Throws run::Abandoned.
[[nodiscard]] archive::PointRecord compute_timestep_point(const StudyConfig& config,
                                                          const run::CaseSpec& spec,
                                                          const run::Heartbeat& heartbeat);

/// Explicit steps that such a point will take, all lanes side by side counting as one; about.
[[nodiscard]] double explicit_steps_of_point(const StudyConfig& config, const run::CaseSpec& spec);

} // namespace culm::study
