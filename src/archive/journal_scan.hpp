// SPDX-License-Identifier: BSD-3-Clause
// Reading journals: an index of what is whole, a count of what is not, and single records.
#pragma once

#include "archive/file_descriptor.hpp"
#include "archive/point_record.hpp"

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace culm::archive {

/// Where a whole record stands in its journal.
struct JournalEntry {
    std::int64_t point = 0;
    PointStatus status = PointStatus::Completed;
    std::uint64_t offset = 0; ///< of the record's header in the file, bytes
    std::uint64_t length = 0; ///< of header and payload, bytes
};

/// What one journal holds.
struct JournalScan {
    std::string file;
    bool header_finished = true;       ///< false: died before the header was written; no entries
    std::vector<JournalEntry> entries; ///< whole records in the order of the file
    std::uint64_t valid_end = 0;       ///< behind the last whole record (or the header), bytes
    std::uint64_t torn_tail_bytes = 0; ///< behind valid_end
    std::uint64_t skipped_bytes = 0;   ///< damaged, with whole records behind them
    std::int64_t damaged_regions = 0;  ///< stretches that make up skipped_bytes
    std::int64_t corrupt_records = 0;  ///< whole header, but the payload fails its checksum
};

/// Reads the whole journal once, in blocks, and checks every checksum; payloads are not kept.
/// Damage behind the header is skipped up to the next whole record and counted, never thrown.
/// InputError: the journal belongs to another study. StorageError: it cannot be read, is no
/// journal, has another version, or its header is damaged.
[[nodiscard]] JournalScan scan_journal(const std::filesystem::path& path,
                                       std::string_view identity);
[[nodiscard]] JournalScan scan_journal(const FileDescriptor& file, std::string_view identity);

/// scan_journal for every file *.culmj of the folder, in order of their names; empty if there is no
/// such folder.
[[nodiscard]] std::vector<JournalScan> scan_journal_folder(const std::filesystem::path& folder,
                                                           std::string_view identity);

/// The identity text of a journal, for which the study need not be known. StorageError as above.
[[nodiscard]] std::string read_journal_identity(const std::filesystem::path& path);

/// One record, its checksums verified again. StorageError if it is no longer what was scanned.
[[nodiscard]] PointRecord read_record(const FileDescriptor& file, const JournalEntry& entry);

} // namespace culm::archive
