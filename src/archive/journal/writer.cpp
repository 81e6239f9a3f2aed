// SPDX-License-Identifier: BSD-3-Clause
#include "archive/journal/writer.hpp"

#include "archive/journal/format.hpp"
#include "archive/journal/read.hpp"
#include "core/error.hpp"

#include <system_error>
#include <vector>

namespace culm::archive {

namespace {

FileDescriptor open_for_append(const std::filesystem::path& path) {
    std::error_code error;
    if (path.has_parent_path())
        std::filesystem::create_directories(path.parent_path(), error);
    if (error)
        throw_storage_error("create the folder", path.parent_path(), error.value());
    return {path, FileDescriptor::Access::ReadWriteCreate};
}

} // namespace

JournalWriter::JournalWriter(const std::filesystem::path& path, std::string_view identity,
                             const JournalOptions& options)
    : file_(open_for_append(path)), options_(options) {
    // Lock before the scan: another writer could append between scan and truncation.
    file_.lock_exclusively(options.lock_wait);
    const JournalScan found = scan_journal(file_, identity);
    end_ = found.valid_end;
    if (found.torn_tail_bytes > 0)
        file_.truncate(end_);
    if (!found.header_finished)
        start(identity);
}

JournalWriter::~JournalWriter() {
    try {
        close();
    } catch (const core::StorageError&) {
        // Every committed record is in the kernel already; a destructor cannot report an error.
        return;
    }
}

/// The header is synchronised at once, with the folder's entry: if a power cut destroyed it, all
/// records of the journal would be lost.
void JournalWriter::start(std::string_view identity) {
    const std::vector<std::byte> header = encode_journal_header(identity);
    try {
        file_.write_at(header, 0);
        file_.sync_data();
    } catch (const core::StorageError&) {
        cut_to_end();
        throw;
    }
    end_ = header.size();
    const std::filesystem::path folder = file_.path().parent_path();
    sync_path(folder.empty() ? "." : folder);
}

void JournalWriter::append(const PointRecord& record) {
    write(encode_record(record));
}

void JournalWriter::mark_started(std::span<const std::int64_t> points) {
    write(encode_marks(points, RecordKind::Started));
}

void JournalWriter::mark_given_back(std::span<const std::int64_t> points) {
    write(encode_marks(points, RecordKind::GivenBack));
}

void JournalWriter::write(std::span<const std::byte> bytes) {
    if (tail_is_dirty_) {
        file_.truncate(end_);
        tail_is_dirty_ = false;
    }
    const std::uint64_t before = end_;
    try {
        file_.write_at(bytes, before);
        end_ = before + bytes.size();
        is_unsynced_ = true;
        if (std::chrono::steady_clock::now() - last_sync_ >= options_.sync_interval)
            sync();
    } catch (const core::StorageError&) {
        // The disk may have room again later; without the torn record the journal stays intact.
        end_ = before;
        cut_to_end();
        throw;
    }
}

void JournalWriter::sync() {
    if (!is_unsynced_)
        return;
    file_.sync_data();
    is_unsynced_ = false;
    last_sync_ = std::chrono::steady_clock::now();
}

void JournalWriter::close() {
    if (!file_.is_open())
        return;
    sync();
    file_.close();
}

void JournalWriter::cut_to_end() noexcept {
    try {
        file_.truncate(end_);
    } catch (const core::StorageError&) {
        tail_is_dirty_ = true; // readers skip the torn tail; the next append tries again
    }
}

} // namespace culm::archive
