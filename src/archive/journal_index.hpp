// SPDX-License-Identifier: BSD-3-Clause
// Where the record of each point stands among the journals of a study, and reading it.
#pragma once

#include "archive/file_descriptor.hpp"
#include "archive/journal_scan.hpp"
#include "archive/point_record.hpp"

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace culm::archive {

/// The entry to be used for each point that the journals know: a completed one before a failed one,
/// else the later one in the order given. 40 bytes a point: a study may have millions.
class JournalIndex {
  public:
    explicit JournalIndex(std::span<const JournalScan> scans);

    [[nodiscard]] bool contains(std::int64_t point) const { return find(point) != nullptr; }
    /// std::out_of_range if the index does not know the point.
    [[nodiscard]] const JournalEntry& at(std::int64_t point) const;
    [[nodiscard]] std::size_t size() const { return places_.size(); }

    /// The record of a point, or nothing if the index does not know it; StorageError as for
    /// read_record. Journals stay open for the next record, some dozens of them at a time.
    [[nodiscard]] std::optional<PointRecord> find_record(std::int64_t point);

  private:
    struct Place {
        JournalEntry entry;
        std::uint32_t file; ///< in files_
    };

    [[nodiscard]] const Place* find(std::int64_t point) const;

    std::vector<std::string> files_;
    std::vector<Place> places_; ///< ordered by point, each point once
    std::map<std::uint32_t, FileDescriptor> open_;
};

} // namespace culm::archive
