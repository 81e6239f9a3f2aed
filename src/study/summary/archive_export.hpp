// SPDX-License-Identifier: BSD-3-Clause
// An archive as CSV tables for other programs.
#pragma once

#include "study/execute/study_folder.hpp"

#include <cstdint>
#include <filesystem>

namespace culm::study {

struct ExportOutcome {
    std::int64_t points = 0;
    std::int64_t missing = 0;
};

/// Writes points.csv (point, status, factors, results, reason of failure: one line a point; a cell
/// is empty where there is no value). The text of a study does not depend on the ranks that
/// computed it. InputError: no archive. StorageError: damage, disk full.
[[nodiscard]] ExportOutcome export_archive(const StudyFolder& folder,
                                           const std::filesystem::path& target);

} // namespace culm::study
