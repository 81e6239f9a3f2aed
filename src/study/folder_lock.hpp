// SPDX-License-Identifier: BSD-3-Clause
// One job at a time in a study's folder.
#pragma once

#include "archive/file_descriptor.hpp"
#include "study/study_folder.hpp"

namespace culm::study {

/// Holds the folder from before it is read until the archive is written: between the reading and
/// the first journal of a job no other one may change what was read. The lock is the system's
/// (flock), so it ends with the process however that ends; the file is removed in order.
class FolderLock {
  public:
    /// The folder must exist. StorageError if another process holds it, or the disk is full.
    explicit FolderLock(const StudyFolder& folder);
    ~FolderLock();
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;

  private:
    archive::FileDescriptor file_;
};

} // namespace culm::study
