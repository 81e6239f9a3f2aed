// SPDX-License-Identifier: BSD-3-Clause
#include "study/folder_lock.hpp"

#include <filesystem>
#include <system_error>

#include <sys/stat.h>

namespace culm::study {
namespace {

archive::FileDescriptor locked(const std::filesystem::path& path) {
    archive::FileDescriptor file(path, archive::FileDescriptor::Access::ReadWriteCreate);
    file.lock_exclusively();
    return file;
}

/// Whether the path still leads to that file: the job before may have removed it meanwhile.
bool is_at(const std::filesystem::path& path, const archive::FileDescriptor& file) {
    struct stat named {};
    return ::stat(path.c_str(), &named) == 0 && file.is_same_file(named.st_dev, named.st_ino);
}

archive::FileDescriptor hold(const std::filesystem::path& path) {
    archive::FileDescriptor file = locked(path);
    while (!is_at(path, file))
        file = locked(path);
    return file;
}

} // namespace

FolderLock::FolderLock(const StudyFolder& folder) : file_(hold(folder.lock())) {}

FolderLock::~FolderLock() {
    std::error_code ignored; // a lock file that stays behind locks nothing
    std::filesystem::remove(file_.path(), ignored);
}

} // namespace culm::study
