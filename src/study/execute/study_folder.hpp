// SPDX-License-Identifier: BSD-3-Clause
// The folder of a study: its journals while it runs, its archive afterwards.
#pragma once

#include "archive/file_descriptor.hpp"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace culm::study {

/// Paths inside a study's folder.
class StudyFolder {
  public:
    explicit StudyFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

    [[nodiscard]] const std::filesystem::path& path() const { return folder_; }
    [[nodiscard]] std::filesystem::path archive() const { return folder_ / "study.h5"; }
    [[nodiscard]] std::filesystem::path journals() const { return folder_ / "journal"; }
    [[nodiscard]] std::filesystem::path journal_of_rank(int rank) const;
    /// Description of the running study (journal_notes.hpp).
    [[nodiscard]] std::filesystem::path note() const { return journals() / "study.json"; }
    /// Computing times of its points so far (journal_notes.hpp).
    [[nodiscard]] std::filesystem::path pace() const { return journals() / "pace.json"; }
    /// Held by the job that works in the folder (study_folder.hpp).
    [[nodiscard]] std::filesystem::path lock() const { return folder_ / "study.lock"; }
    [[nodiscard]] std::filesystem::path summary() const { return folder_ / "summary.json"; }

  private:
    std::filesystem::path folder_;
};

/// Whether there is such a file or folder. Throws core::InputError when that is unknown, for
/// example because the folder above may not be searched.
[[nodiscard]] bool is_there(const std::filesystem::path& path);

/// Creates the folder if need be. Throws core::InputError when it may not be written,
/// core::StorageError when the disk has no room for it.
void make_writable(const StudyFolder& folder);

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
};

/// Prepares the folder for a study with this identity and number of points, and verifies every
/// checksum of its contents. Throws core::InputError when it contains another study (with the
/// differing settings), this one without ResumeOptions::resume, or an archive that is damaged, and
/// when it may not be written; core::StorageError when the disk has no room for it.
[[nodiscard]] FolderContent prepare_folder(const StudyFolder& folder, const std::string& identity,
                                           std::int64_t point_count, const ResumeOptions& options);

/// Locks the folder from before it is read until the archive is written: no other job may change it
/// between the reading and the first journal of this job. The lock is the system's (flock), so it
/// ends with the process in any case; the file is removed at a regular end.
class FolderLock {
  public:
    /// The folder must exist. StorageError if another process holds it until the wait is over, or
    /// the disk is full.
    explicit FolderLock(const StudyFolder& folder, const archive::LockWait& wait = {});
    ~FolderLock();
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;

  private:
    archive::FileDescriptor file_;
};

} // namespace culm::study
