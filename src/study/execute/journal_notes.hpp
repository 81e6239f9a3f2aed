// SPDX-License-Identifier: BSD-3-Clause
// Files next to the journals: the study that they belong to, and the times of its points so far.
#pragma once

#include "archive/study/description.hpp"
#include "farm/pace.hpp"
#include "study/execute/study_folder.hpp"

#include <cstdint>
#include <optional>

namespace culm::study {

/// Replaces the folder's note atomically: readers find the old or the new one. `note`: the texts of
/// provenance_of(), and "points", "start" and "ranks" of the latest run, with the points that it
/// had to compute ("pending") and the outcomes in the journals before it ("journalled").
/// StorageError.
void write_note(const StudyFolder& folder, const archive::Texts& note);

/// Empty if there is no note (an archive without journals, or journals of an older culm).
/// StorageError if the file cannot be read or is not a note.
[[nodiscard]] std::optional<archive::Texts> read_note(const StudyFolder& folder);

/// The number of points that a note states. StorageError if no study can have it.
[[nodiscard]] std::int64_t points_of(const archive::Texts& note);

/// Cost unit: seconds on the reference machine (study::estimated_seconds). The pace is empty if the
/// file is missing or not valid; times are then measured anew.
[[nodiscard]] farm::Pace read_pace(const StudyFolder& folder);

/// Replaces the file atomically if the folder has journals. A failure is ignored: points do not
/// depend on it.
void write_pace(const StudyFolder& folder, const farm::Pace& pace);

} // namespace culm::study
