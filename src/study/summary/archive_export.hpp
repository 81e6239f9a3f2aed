// SPDX-License-Identifier: BSD-3-Clause
// An archive as CSV tables for other programs.
#pragma once

#include "study/execute/study_folder.hpp"

#include <cstdint>
#include <filesystem>

namespace culm::study {

struct ExportOptions {
    bool histories = false; ///< point_000012.csv: time and deflections of each completed point
};

struct ExportOutcome {
    std::int64_t points = 0;
    std::int64_t missing = 0;
    std::int64_t histories = 0;
};

/// Writes points.csv (point, status, factors, results, reason of failure: one line a point; a cell
/// is empty where there is no value) and what the options request. The text of a study does not
/// depend on the ranks that computed it.
/// InputError: no archive, or it stores no such histories. StorageError: damage, disk full.
[[nodiscard]] ExportOutcome export_archive(const StudyFolder& folder,
                                           const std::filesystem::path& target,
                                           const ExportOptions& options);

} // namespace culm::study
