// SPDX-License-Identifier: BSD-3-Clause
#include "study/execute/study_folder.hpp"

#include "core/error.hpp"

#include <cerrno>
#include <filesystem>
#include <system_error>

#include <fmt/core.h>
#include <sys/stat.h>
#include <unistd.h>

namespace culm::study {

namespace {

namespace fs = std::filesystem;

archive::FileDescriptor hold(const fs::path& path, const archive::LockWait& wait) {
    while (true) {
        archive::FileDescriptor file(path, archive::FileDescriptor::Access::ReadWriteCreate);
        file.lock_exclusively(wait);
        struct stat named {};
        // The previous job may have removed the file between opening and locking; the lock would
        // then be on a file that no other process can find.
        if (::stat(path.c_str(), &named) == 0 && file.is_same_file(named.st_dev, named.st_ino))
            return file;
    }
}

} // namespace

bool is_there(const fs::path& path) {
    std::error_code error;
    const bool exists = fs::exists(path, error);
    if (error)
        throw core::InputError(
            fmt::format("cannot look for {}: {}", path.string(), error.message()));
    return exists;
}

void make_writable(const StudyFolder& folder) {
    const std::string name = folder.path().string();
    std::error_code error;
    fs::create_directories(folder.path(), error);
    if (error == std::errc::no_space_on_device)
        throw core::StorageError(
            fmt::format("cannot create the folder {}: {}", name, error.message()));
    if (error)
        throw core::InputError(fmt::format(
            "cannot create the folder {}: {}; choose another one with -o", name, error.message()));
    if (::access(name.c_str(), W_OK | X_OK) != 0)
        throw core::InputError(
            fmt::format("cannot write to the folder {}: {}; choose another one with -o", name,
                        std::generic_category().message(errno)));
}

fs::path StudyFolder::journal_of_rank(int rank) const {
    return journals() / fmt::format("rank-{:05d}.culmj", rank);
}

FolderLock::FolderLock(const StudyFolder& folder, const archive::LockWait& wait)
    : file_(hold(folder.lock(), wait)) {}

FolderLock::~FolderLock() {
    std::error_code ignored; // a remaining lock file locks nothing
    std::filesystem::remove(file_.path(), ignored);
}

} // namespace culm::study
