// SPDX-License-Identifier: BSD-3-Clause
// An open POSIX file: unbuffered writes at an offset, and errors that name file and cause.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string_view>
#include <utility>

#include <sys/types.h>

namespace culm::archive {

/// How long to wait for a lock that another process holds.
struct LockWait {
    std::chrono::milliseconds patience{5}; ///< is_locked() itself holds the lock for microseconds
    /// Called once, after 0.2 s of waiting; may be empty.
    std::function<void()> announce;
    /// Called repeatedly; true ends the wait. May be empty.
    std::function<bool()> give_up;
};

/// Owns a file descriptor. Every failure is a StorageError with path and the system's text for
/// errno ("No space left on device").
class FileDescriptor {
  public:
    enum class Access { Read, ReadWriteCreate };

    FileDescriptor(std::filesystem::path path, Access access);
    ~FileDescriptor();
    FileDescriptor(FileDescriptor&& other) noexcept
        : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)) {}
    FileDescriptor& operator=(FileDescriptor&& other) noexcept;
    FileDescriptor(const FileDescriptor&) = delete;
    FileDescriptor& operator=(const FileDescriptor&) = delete;

    [[nodiscard]] const std::filesystem::path& path() const { return path_; }
    [[nodiscard]] bool is_open() const { return descriptor_ >= 0; }
    [[nodiscard]] std::uint64_t size() const;

    /// Writes all bytes at the offset; interrupted and short writes are continued. From time to
    /// time it asks the kernel to start writing its pages to the disk, which shortens the wait in
    /// sync_data.
    void write_at(std::span<const std::byte> bytes, std::uint64_t offset);
    /// write_at for data that this process does not read soon. It starts writing them to the disk
    /// and frees the memory of what is there: a process that goes on in the same memory writes
    /// three times as fast, and other files stay in the cache.
    void write_behind(std::span<const std::byte> bytes, std::uint64_t offset);
    /// Reads up to bytes.size() bytes; fewer only at the end of the file.
    [[nodiscard]] std::size_t read_at(std::span<std::byte> bytes, std::uint64_t offset) const;
    void truncate(std::uint64_t size);
    /// fdatasync: content (and the size needed to find it) is on the disk when this returns.
    void sync_data();
    /// StorageError if another process still holds the lock when `wait` is over. Succeeds on file
    /// systems without locks.
    void lock_exclusively(const LockWait& wait = {});
    /// Whether another process holds the lock; false if that is unknown.
    [[nodiscard]] bool is_locked() const;
    /// Whether the file system has locks.
    [[nodiscard]] bool can_be_locked() const;
    /// Whether this is the file with that device and inode number.
    [[nodiscard]] bool is_same_file(dev_t device, ino_t inode) const;
    /// Closes the file and reports errors of delayed writes.
    void close();

  private:
    [[nodiscard]] int lock_error() const;

    std::uint64_t unsent_bytes_ = 0; ///< written since the kernel was last asked to write pages
    std::filesystem::path path_;
    int descriptor_ = -1;
};

/// fsync of a closed file or of a folder (so that a new or renamed entry survives a power cut).
void sync_path(const std::filesystem::path& path);

/// Throws StorageError "cannot <action> <path>: <text of errno>".
[[noreturn]] void throw_storage_error(std::string_view action, const std::filesystem::path& path,
                                      int error_number);

} // namespace culm::archive
