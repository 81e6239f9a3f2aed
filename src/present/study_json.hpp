// SPDX-License-Identifier: BSD-3-Clause
// A study and its repetition as the files that programs read.
#pragma once

#include "study/execute/repetition.hpp"
#include "study/summary/summary.hpp"
#include "study/summary/timestep_summary.hpp"

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

} // namespace culm::present
