// SPDX-License-Identifier: BSD-3-Clause
// Files next to the journals: the study that they belong to, and the times of its points so far.
#pragma once

#include "archive/study/description.hpp"
#include "farm/pace.hpp"
#include "study/execute/plan.hpp"
#include "study/execute/study_folder.hpp"

#include <cstdint>
#include <optional>
#include <string>

namespace culm::study {

struct StudyNote {
    std::string name;
    std::int64_t points = 0;
    std::string config;      ///< text of the study file
    std::string config_file; ///< its name
    std::string start;       ///< of the latest run, UTC
    int ranks = 1;           ///< of the latest run
    /// Facts about the program that computes: name and text.
    archive::Texts provenance;
    StudyFiles files; ///< that the study names

    bool operator==(const StudyNote&) const = default;
};

/// Replaces the folder's note atomically: readers find the old or the new one. StorageError.
void write_note(const StudyFolder& folder, const StudyNote& note);

/// Empty if there is no note (an archive without journals, or journals of an older culm).
/// StorageError if the file cannot be read or is not a note.
[[nodiscard]] std::optional<StudyNote> read_note(const StudyFolder& folder);

/// Cost unit: seconds on the reference machine (study::estimated_seconds). The pace is empty if the
/// file is missing or not valid; times are then measured anew.
[[nodiscard]] farm::Pace read_pace(const StudyFolder& folder);

/// Replaces the file atomically if the folder has journals. A failure is ignored: points do not
/// depend on it.
void write_pace(const StudyFolder& folder, const farm::Pace& pace);

} // namespace culm::study
