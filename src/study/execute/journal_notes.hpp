// SPDX-License-Identifier: BSD-3-Clause
// Files beside the journals: what study they belong to, and what its points took so far.
#pragma once

#include "farm/batch.hpp"
#include "farm/communicator.hpp"
#include "farm/pace.hpp"
#include "study/execute/plan.hpp"
#include "study/execute/study_folder.hpp"

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

/// Cost unit: seconds on the reference machine (study::estimated_seconds). Nothing known if there
/// is no such file or it cannot be understood: then times are learned anew.
[[nodiscard]] farm::Pace read_pace(const StudyFolder& folder);

/// Replaces the file at once, as long as the folder has journals. A failure is ignored: points do
/// not depend on it.
void write_pace(const StudyFolder& folder, const farm::Pace& pace);

/// What earlier runs left about the times of these batches, the same on every rank. It weighs no
/// more than one batch for each rank: the machine may be another one. Collective.
[[nodiscard]] farm::Pace earlier_pace(const StudyFolder& folder,
                                      const std::vector<farm::Batch>& batches,
                                      const farm::Communicator* communicator);

/// Expected for the cheapest of the batches, s; as make_batches plans while nothing is known.
[[nodiscard]] double shortest_expected_time(const std::vector<farm::Batch>& batches,
                                            const farm::Pace& pace);

} // namespace culm::study
