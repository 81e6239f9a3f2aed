// SPDX-License-Identifier: BSD-3-Clause
#include "archive/file_descriptor.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <system_error>
#include <thread>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace culm::archive {

namespace {

int open_checked(const std::filesystem::path& path, int flags) {
    constexpr mode_t permissions = 0666; // reduced by the user's umask
    int descriptor = -1;
    // A signal must not look like a broken disk: batch systems send one before the end of a job.
    do {
        descriptor = ::open(path.c_str(), flags | O_CLOEXEC, permissions);
    } while (descriptor < 0 && errno == EINTR);
    if (descriptor < 0)
        throw_storage_error("open", path, errno);
    return descriptor;
}

} // namespace

void throw_storage_error(std::string_view action, const std::filesystem::path& path,
                         int error_number) {
    throw core::StorageError(fmt::format("cannot {} {}: {}", action, path.string(),
                                         std::generic_category().message(error_number)));
}

FileDescriptor::FileDescriptor(std::filesystem::path path, Access access)
    : path_(std::move(path)),
      descriptor_(open_checked(path_, access == Access::Read ? O_RDONLY : O_RDWR | O_CREAT)) {}

FileDescriptor::~FileDescriptor() {
    if (is_open())
        ::close(descriptor_);
}

FileDescriptor& FileDescriptor::operator=(FileDescriptor&& other) noexcept {
    std::swap(path_, other.path_);
    std::swap(descriptor_, other.descriptor_);
    return *this;
}

std::uint64_t FileDescriptor::size() const {
    struct stat status {};
    if (::fstat(descriptor_, &status) != 0)
        throw_storage_error("examine", path_, errno);
    return static_cast<std::uint64_t>(status.st_size);
}

void FileDescriptor::write_at(std::span<const std::byte> bytes, std::uint64_t offset) {
    while (!bytes.empty()) {
        const ssize_t written =
            ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
        if (written < 0 && errno == EINTR)
            continue;
        if (written <= 0) // POSIX allows 0 if the disk is full
            throw_storage_error("write", path_, written < 0 ? errno : ENOSPC);
        bytes = bytes.subspan(static_cast<std::size_t>(written));
        offset += static_cast<std::uint64_t>(written);
        unsent_bytes_ += static_cast<std::uint64_t>(written);
    }
    // By default the kernel collects dirty pages for half a minute. The next fdatasync would then
    // wait for all of them, and the rank would compute nothing meanwhile.
    constexpr std::uint64_t writeback_bytes = std::uint64_t{8} << 20U;
    if (unsent_bytes_ < writeback_bytes)
        return;
#ifdef SYNC_FILE_RANGE_WRITE
    // Starts the writeback without waiting; sync_data reports its errors. A length of zero means
    // "to the end of the file".
    (void)::sync_file_range(descriptor_, 0, 0, SYNC_FILE_RANGE_WRITE);
#endif
    unsent_bytes_ = 0;
}

void FileDescriptor::write_behind(std::span<const std::byte> bytes, std::uint64_t offset) {
    write_at(bytes, offset);
    // The kernel keeps pages that it is still writing, so nothing waits for the disk here.
    (void)::posix_fadvise(descriptor_, 0, static_cast<off_t>(offset + bytes.size()),
                          POSIX_FADV_DONTNEED);
}

std::size_t FileDescriptor::read_at(std::span<std::byte> bytes, std::uint64_t offset) const {
    std::size_t total = 0;
    while (total < bytes.size()) {
        const ssize_t got = ::pread(descriptor_, bytes.data() + total, bytes.size() - total,
                                    static_cast<off_t>(offset + total));
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            throw_storage_error("read", path_, errno);
        if (got == 0)
            break;
        total += static_cast<std::size_t>(got);
    }
    return total;
}

void FileDescriptor::truncate(std::uint64_t size) {
    if (::ftruncate(descriptor_, static_cast<off_t>(size)) != 0)
        throw_storage_error("truncate", path_, errno);
}

void FileDescriptor::sync_data() {
    // EINVAL: a pipe or device cannot be synchronised and needs no synchronisation.
    if (::fdatasync(descriptor_) != 0 && errno != EINVAL)
        throw_storage_error("synchronise", path_, errno);
}

void FileDescriptor::lock_exclusively(const LockWait& wait) {
    using std::chrono::steady_clock;
    constexpr auto unnoticed = std::chrono::milliseconds(200);
    const auto start = steady_clock::now();
    auto pause = std::chrono::milliseconds(1);
    // Any other error means that the file system does not support locks (ENOLCK, EOPNOTSUPP). The
    // study then runs without this protection.
    for (bool announced = false;
         ::flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;) {
        const auto waited = steady_clock::now() - start;
        if (waited >= wait.patience || (wait.give_up && wait.give_up()))
            throw core::StorageError(fmt::format(
                "cannot write {}: another process has it open; is the study running already?",
                path_.string()));
        if (waited >= unnoticed && !std::exchange(announced, true) && wait.announce)
            wait.announce();
        std::this_thread::sleep_for(pause);
        pause = std::min(2 * pause, unnoticed);
    }
}

/// 0 if the file could be locked now; else the reason.
int FileDescriptor::lock_error() const {
    if (::flock(descriptor_, LOCK_SH | LOCK_NB) != 0)
        return errno;
    (void)::flock(descriptor_, LOCK_UN);
    return 0;
}

bool FileDescriptor::is_locked() const {
    return lock_error() == EWOULDBLOCK;
}

bool FileDescriptor::can_be_locked() const {
    const int error = lock_error();
    return error == 0 || error == EWOULDBLOCK;
}

bool FileDescriptor::is_same_file(dev_t device, ino_t inode) const {
    struct stat status {};
    return ::fstat(descriptor_, &status) == 0 && status.st_dev == device && status.st_ino == inode;
}

void FileDescriptor::close() {
    // Network file systems report the failure of a delayed write only here.
    if (is_open() && ::close(std::exchange(descriptor_, -1)) != 0)
        throw_storage_error("close", path_, errno);
}

void sync_path(const std::filesystem::path& path) {
    const int descriptor = open_checked(path, O_RDONLY);
    const int result = ::fsync(descriptor);
    const int error_number = errno;
    ::close(descriptor);
    // EINVAL: some network file systems do not synchronise folders.
    if (result != 0 && error_number != EINVAL)
        throw_storage_error("synchronise", path, error_number);
}

} // namespace culm::archive
