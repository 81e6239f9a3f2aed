// SPDX-License-Identifier: BSD-3-Clause
// Appending completed points to a journal so that they survive the death of the process.
#pragma once

#include "archive/file_descriptor.hpp"
#include "archive/point_record.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

namespace culm::archive {

struct JournalOptions {
    /// An append calls fdatasync if the last call is at least this long ago; 0: every append does.
    /// A record is in the kernel when append returns, so kill -9 never loses it. fdatasync protects
    /// against a crash of the whole node; it takes milliseconds and is therefore not called for
    /// every point.
    std::chrono::milliseconds sync_interval{10'000};
    LockWait lock_wait;
};

/// One rank's journal. Nothing is buffered in user space. One writer per file: the file is locked.
class JournalWriter {
  public:
    /// Creates the journal (and its folder), or continues it: an incomplete record at its end is
    /// cut off first. InputError if it belongs to another study; StorageError if it cannot be
    /// opened or written, is in use, or is not a readable journal.
    JournalWriter(const std::filesystem::path& path, std::string_view identity,
                  const JournalOptions& options = {});
    /// Closes the file and ignores errors; close() reports them.
    ~JournalWriter();
    JournalWriter(JournalWriter&&) = default;
    JournalWriter& operator=(JournalWriter&&) = delete;
    JournalWriter(const JournalWriter&) = delete;
    JournalWriter& operator=(const JournalWriter&) = delete;

    /// The point is committed when this returns. On StorageError (disk full, I/O error) it is not:
    /// the partial record has been cut off again, so that the journal stays intact and a later
    /// append may succeed.
    void append(const PointRecord& record);
    /// Marks the points as started. If a point is neither appended nor given back later, the
    /// process died while it computed the point. StorageError as for append.
    void mark_started(std::span<const std::int64_t> points);
    /// Cancels the marks of points that the process did not finish before an orderly stop.
    void mark_given_back(std::span<const std::int64_t> points);
    /// fdatasync now.
    void sync();
    /// fdatasync and close; append must not be called afterwards.
    void close();

    [[nodiscard]] const std::filesystem::path& path() const { return file_.path(); }

  private:
    void start(std::string_view identity);
    void write(std::span<const std::byte> bytes);
    void cut_to_end() noexcept;

    FileDescriptor file_;
    JournalOptions options_;
    std::uint64_t end_ = 0;      ///< end of the last committed record, bytes
    bool tail_is_dirty_ = false; ///< a failed append could not be cut off yet
    bool is_unsynced_ = false;
    std::chrono::steady_clock::time_point last_sync_ = std::chrono::steady_clock::now();
};

} // namespace culm::archive
