// SPDX-License-Identifier: BSD-3-Clause
// A study's folder (culm archive info, status and verify) and its results as files for programs and
// as text: regressions, spread, limits of the time step.
#pragma once

#include "study/execute/folder_state.hpp"
#include "study/summary/summary.hpp"

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace culm::present {

/// summary.json; docs/summary-format.md.
[[nodiscard]] nlohmann::json summary_json(const study::StudySummary& summary);
[[nodiscard]] nlohmann::json summary_json(const study::TimestepSummary& summary);
[[nodiscard]] nlohmann::json summary_schema();

/// Writes summary.json and fits.csv (one line per point) into the folder.
void write_summary(const study::StudyFolder& folder, const study::StudySummary& summary);

/// Writes summary.json into the folder.
void write_summary(const study::StudyFolder& folder, const study::TimestepSummary& summary);

/// The two laws of the paper with their intervals and the published values, the terms that the
/// F-tests kept, the residuals, the spread of a study with distributions (between and within stems,
/// and its shares by factor), and the failed points.
[[nodiscard]] std::string regression_table(const study::StudySummary& summary);

/// The bisected limits with the linearised ones and the authors' rule, the laws of the limit, the
/// errors of smaller steps, and the failed points.
[[nodiscard]] std::string timestep_table(const study::TimestepSummary& summary);

/// "0-3, 7, 9-12": the first `most` ranges of ascending points, then how many points follow.
[[nodiscard]] std::string ranges_text(const std::vector<std::int64_t>& points,
                                      std::size_t most = 12);

/// Content of the folder: study, points, tables, histories, provenance, size.
[[nodiscard]] std::string info_text(const study::StudyFolder& folder,
                                    const study::FolderState& state);

/// Progress of the study, its processes, and the points being computed.
[[nodiscard]] std::string status_text(const study::FolderState& state);

/// Whether the folder is complete, and its damaged and missing parts.
[[nodiscard]] std::string verify_text(const study::FolderState& state);

/// The JSON of all three commands (docs/archive-format.md).
[[nodiscard]] nlohmann::json folder_json(const study::FolderState& state);
[[nodiscard]] nlohmann::json folder_schema();

} // namespace culm::present
