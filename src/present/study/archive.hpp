// SPDX-License-Identifier: BSD-3-Clause
// A study's folder as text and JSON: culm archive info, status and verify.
#pragma once

#include "study/execute/folder_state.hpp"

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace culm::present {

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
[[nodiscard]] nlohmann::ordered_json to_json(const study::FolderState& state);

} // namespace culm::present
