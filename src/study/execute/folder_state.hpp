// SPDX-License-Identifier: BSD-3-Clause
// Contents of a study's folder, complete or not, running or not: for info, status, verify and
// a run that continues it.
#pragma once

#include "archive/journal/read.hpp"
#include "archive/point_record.hpp"
#include "archive/study/description.hpp"
#include "archive/study/file.hpp"
#include "study/execute/study_folder.hpp"

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace culm::study {

/// One journal of the folder.
struct JournalState {
    archive::JournalScan scan;
    bool is_locked = false; ///< a process writes it
    double age_s = 0.0;     ///< since its last change
    std::vector<std::int64_t> computing =
        {}; ///< missing points that this process has begun, ascending

    [[nodiscard]] bool is_waiting() const { return is_locked && computing.empty(); }
};

struct PointCounts {
    std::int64_t total = 0; ///< in the design
    std::int64_t completed = 0;
    std::int64_t failed = 0;
    std::int64_t missing = 0;
};

struct FolderState {
    std::string identity;                                    ///< canonical configuration
    std::optional<archive::StudyDescription> archive;        ///< of study.h5, if it can be read
    std::optional<archive::Verification> verification;       ///< of study.h5, if it was asked for
    std::optional<archive::Texts> note;                      ///< next to the journals
    std::vector<JournalState> journals;                      ///< in order of their names
    std::vector<std::string> problems;                       ///< files that cannot be read, and why
    std::optional<std::vector<archive::PointStatus>> points; ///< nothing: their number is unknown
    std::int64_t repeated_outcomes = 0; ///< outcomes in the journals that others supersede
    std::map<std::int64_t, int> deaths; ///< unfinished starts of points of the design
    std::optional<double> remaining_s;  ///< of a running study, if its next points take as long
    std::uint64_t archive_bytes = 0;
    std::uint64_t journal_bytes = 0;

    [[nodiscard]] PointCounts counts() const;
    /// Those of points without an outcome.
    [[nodiscard]] std::map<std::int64_t, int> unfinished_starts() const;
    [[nodiscard]] bool is_running() const {
        return std::ranges::any_of(journals, &JournalState::is_locked);
    }
    /// True if nothing is damaged and nothing is missing.
    [[nodiscard]] bool is_whole() const;
};

/// Depth of the inspection of a folder.
enum class FolderDepth {
    Glance, ///< headers of journal records and of the archive: quick, trusts the payloads
    Verify, ///< every checksum
};

/// Reads a study's folder and changes nothing in it. Damage is listed, not thrown.
/// InputError if there is no study, or if its files belong to different studies.
[[nodiscard]] FolderState read_folder_state(const StudyFolder& folder, FolderDepth depth);

/// Treatment of a folder that already contains the study.
struct ResumeOptions {
    bool resume = false;       ///< continue it; otherwise it is refused
    bool retry_failed = false; ///< failed points are computed again
    /// Number of deaths of processes after which a point is not tried again; 0: no limit.
    int crash_limit = 5;
};

/// Points of a study that a folder already contains.
struct FolderContent {
    bool archive_is_complete = false; ///< study.h5 has every point; no journals, none pending
    std::vector<std::int64_t> pending_points; ///< of the design, to be computed; ascending
    /// Pending points during whose computation a process died before; ascending.
    std::vector<std::int64_t> suspect_points;
    /// Points without an outcome that reached the crash limit; ascending, none of them pending.
    std::vector<std::int64_t> given_up_points;
    std::int64_t journalled = 0; ///< outcomes in the journals
    /// Trajectories that the journals named and that are missing or damaged, in words; their points
    /// are pending.
    std::vector<std::string> lost_trajectories;
};

/// Prepares the folder for a study with this identity and number of points, and verifies every
/// checksum of its contents. Throws core::InputError when it contains another study (with the
/// differing settings), this one without ResumeOptions::resume, or an archive that is damaged, and
/// when it may not be written; core::StorageError when the disk has no room for it.
[[nodiscard]] FolderContent prepare_folder(const StudyFolder& folder, const std::string& identity,
                                           std::int64_t point_count, const ResumeOptions& options);

} // namespace culm::study
