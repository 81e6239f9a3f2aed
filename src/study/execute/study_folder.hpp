// SPDX-License-Identifier: BSD-3-Clause
// The folder of a study: its journals while it runs, its archive afterwards.
#pragma once

#include "archive/file_descriptor.hpp"
#include "archive/trajectory/place.hpp"

#include <filesystem>

namespace culm::study {

/// Paths inside a study's folder.
class StudyFolder {
  public:
    explicit StudyFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

    [[nodiscard]] const std::filesystem::path& path() const { return folder_; }
    [[nodiscard]] std::filesystem::path archive() const { return folder_ / "study.h5"; }
    [[nodiscard]] std::filesystem::path journals() const { return folder_ / "journal"; }
    /// Trajectories of every point, written by the ranks and named by the journals and the archive.
    [[nodiscard]] std::filesystem::path trajectories() const {
        return folder_ / archive::trajectory_folder_name;
    }
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
