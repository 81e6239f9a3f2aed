// SPDX-License-Identifier: BSD-3-Clause
// The results of a study as files for programs and as text: regressions, spread, limits of the time
// step, a repetition.
#pragma once

#include "study/execute/repetition.hpp"
#include "study/summary/summary.hpp"
#include "study/summary/timestep_summary.hpp"

#include <string>

#include <nlohmann/json.hpp>

namespace culm::present {

/// docs/summary-format.md.
[[nodiscard]] nlohmann::json to_json(const study::StudySummary& summary);
[[nodiscard]] nlohmann::json to_json(const study::TimestepSummary& summary);

/// Writes summary.json and fits.csv (one line per point) into the folder.
void write_summary(const study::StudyFolder& folder, const study::StudySummary& summary);

/// Writes summary.json, limits.csv (one line per completed point) and step_errors.csv (one line per
/// completed point and fraction) into the folder.
void write_summary(const study::StudyFolder& folder, const study::TimestepSummary& summary);

/// docs/archive-format.md and docs/schemas/repetition.schema.json.
[[nodiscard]] nlohmann::ordered_json to_json(const study::Repetition& repetition);

/// The two laws of the paper with their intervals and the published values, the terms that the
/// F-tests kept, the residuals, the spread of a study with distributions (between and within stems,
/// and its shares by factor), and the failed points.
[[nodiscard]] std::string regression_table(const study::StudySummary& summary);

/// The bisected limits with the linearised ones and the authors' rule, the laws of the limit, the
/// errors of smaller steps, and the failed points.
[[nodiscard]] std::string timestep_table(const study::TimestepSummary& summary);

/// The archive with which a repetition was compared, and the differences.
[[nodiscard]] std::string repetition_text(const study::Repetition& repetition);

} // namespace culm::present
