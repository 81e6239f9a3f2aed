// SPDX-License-Identifier: BSD-3-Clause
// DIR/journal/study.json: what the journals beside it belong to, for as long as there is no
// archive.
#pragma once

#include "study/plan.hpp"
#include "study/study_folder.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace culm::study {

struct StudyNote {
    std::string name;
    std::int64_t points = 0;
    std::string config;      ///< text of the study file
    std::string config_file; ///< its name
    std::string start;       ///< of the latest run, UTC
    int ranks = 1;           ///< of the latest run
    /// Facts about the program that computes: name and text.
    std::vector<std::pair<std::string, std::string>> provenance;
    StudyFiles files; ///< that the study names

    bool operator==(const StudyNote&) const = default;
};

/// Replaces the folder's note at once: a reader finds the old one or the new one. StorageError.
void write_note(const StudyFolder& folder, const StudyNote& note);

/// Nothing if there is no note (an archive stands alone, or an older culm wrote the journals).
/// StorageError if it cannot be read or is no note.
[[nodiscard]] std::optional<StudyNote> read_note(const StudyFolder& folder);

} // namespace culm::study
