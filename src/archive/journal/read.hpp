// SPDX-License-Identifier: BSD-3-Clause
// Reading journals: an index of intact records, a count of damaged ones, and single records.
#pragma once

#include "archive/file_descriptor.hpp"
#include "archive/point_record.hpp"

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace culm::archive {

/// Position of an intact record in its journal.
struct JournalEntry {
    std::int64_t point = 0;
    PointStatus status = PointStatus::Completed;
    std::uint64_t offset = 0; ///< of the record's header in the file, bytes
    std::uint64_t length = 0; ///< of header and payload, bytes
};

/// Content of one journal.
struct JournalScan {
    std::string file;
    std::uint64_t size = 0;            ///< of the file, bytes
    bool header_finished = true;       ///< false: the process died before; no entries
    std::vector<JournalEntry> entries; ///< intact records in the order of the file
    /// How often each point was started without an outcome and without being given back: once for
    /// every process that died while it computed the point, and once more if one computes it now.
    std::map<std::int64_t, int> unfinished_starts;
    std::uint64_t valid_end = 0;       ///< end of the last intact record (or header), bytes
    std::uint64_t torn_tail_bytes = 0; ///< behind valid_end
    std::uint64_t skipped_bytes = 0;   ///< damaged, but followed by intact records
    std::int64_t damaged_regions = 0;  ///< stretches that make up skipped_bytes
    std::int64_t corrupt_records = 0;  ///< intact header, but wrong checksum of the payload

    [[nodiscard]] bool is_damaged() const {
        return torn_tail_bytes > 0 || skipped_bytes > 0 || corrupt_records > 0;
    }
};

/// How much of a journal a scan reads.
enum class ScanDepth {
    Everything, ///< and checks every checksum
    Headers,    ///< skips the payloads: for the status of a running study
};

/// Reads the journal once, in blocks, and checks every checksum; payloads are not kept.
/// Damage behind the header is skipped up to the next intact record and counted, never thrown.
/// InputError: the journal belongs to another study. StorageError: the file cannot be read or is
/// not a journal, or its version is unknown, or its header is damaged.
[[nodiscard]] JournalScan scan_journal(const std::filesystem::path& path, std::string_view identity,
                                       ScanDepth depth = ScanDepth::Everything);
[[nodiscard]] JournalScan scan_journal(const FileDescriptor& file, std::string_view identity,
                                       ScanDepth depth = ScanDepth::Everything);

/// The files *.culmj of the folder, in order of their names; empty if there is no such folder.
[[nodiscard]] std::vector<std::filesystem::path> journal_files(const std::filesystem::path& folder);

/// scan_journal for each of journal_files.
[[nodiscard]] std::vector<JournalScan> scan_journal_folder(const std::filesystem::path& folder,
                                                           std::string_view identity);

/// The identity text of a journal of any study; nothing if the header was never finished.
/// StorageError as above.
[[nodiscard]] std::optional<std::string> read_journal_identity(const std::filesystem::path& path);

/// One record, its checksums verified again. StorageError if it has changed since the scan.
[[nodiscard]] PointRecord read_record(const FileDescriptor& file, const JournalEntry& entry);

/// Overwrites the beginning of a record, so that later scans skip it: its point must be computed
/// again. StorageError if the file cannot be written.
void discard_record(const std::filesystem::path& journal, const JournalEntry& entry);

/// The entry to be used for each point in the journals: a completed one before a failed one, else
/// the later one in the given order. An entry needs 40 bytes: a study may have millions of points.
class JournalIndex {
  public:
    explicit JournalIndex(std::span<const JournalScan> scans);

    struct Place {
        JournalEntry entry;
        std::uint32_t file; ///< in the order of the scans
    };

    /// Null if the index does not contain the point.
    [[nodiscard]] const Place* find(std::int64_t point) const;
    [[nodiscard]] bool contains(std::int64_t point) const { return find(point) != nullptr; }
    [[nodiscard]] std::size_t size() const { return places_.size(); }

    /// The record of a point; nothing if the index does not contain it. StorageError as for
    /// read_record. Some dozens of journals are kept open for the next record.
    [[nodiscard]] std::optional<PointRecord> find_record(std::int64_t point);

  private:
    std::vector<std::string> files_;
    std::vector<Place> places_; ///< ordered by point, each point once
    std::map<std::uint32_t, FileDescriptor> open_;
};

} // namespace culm::archive
