// SPDX-License-Identifier: BSD-3-Clause
#include "archive/journal_index.hpp"

#include <algorithm>
#include <stdexcept>
#include <tuple>

#include <fmt/format.h>

namespace culm::archive {

namespace {

/// Processes may open some 1000 files; MPI needs its share of them.
constexpr std::size_t most_open_files = 64;

} // namespace

JournalIndex::JournalIndex(std::span<const JournalScan> scans) {
    std::size_t entries = 0;
    for (const JournalScan& scan : scans)
        entries += scan.entries.size();
    places_.reserve(entries);
    for (const JournalScan& scan : scans) {
        const auto file = static_cast<std::uint32_t>(files_.size());
        files_.push_back(scan.file);
        for (const JournalEntry& entry : scan.entries)
            places_.push_back({entry, file});
    }
    // What counts for a point comes last among its places, and is the one that stays.
    std::ranges::sort(places_, {}, [](const Place& place) {
        const bool is_completed = place.entry.status == PointStatus::Completed;
        return std::tuple(place.entry.point, is_completed, place.file, place.entry.offset);
    });
    const auto last =
        std::unique(places_.rbegin(), places_.rend(),
                    [](const auto& a, const auto& b) { return a.entry.point == b.entry.point; });
    places_.erase(places_.begin(), last.base());
}

const JournalIndex::Place* JournalIndex::find(std::int64_t point) const {
    const auto place = std::ranges::lower_bound(
        places_, point, {}, [](const Place& candidate) { return candidate.entry.point; });
    return place != places_.end() && place->entry.point == point ? &*place : nullptr;
}

const JournalEntry& JournalIndex::at(std::int64_t point) const {
    const Place* place = find(point);
    if (place == nullptr)
        throw std::out_of_range(fmt::format("no journal knows point {}", point));
    return place->entry;
}

std::optional<PointRecord> JournalIndex::find_record(std::int64_t point) {
    const Place* place = find(point);
    if (place == nullptr)
        return std::nullopt;
    auto file = open_.find(place->file);
    if (file == open_.end()) {
        if (open_.size() == most_open_files)
            open_.clear();
        file =
            open_.try_emplace(place->file, files_[place->file], FileDescriptor::Access::Read).first;
    }
    return read_record(file->second, place->entry);
}

} // namespace culm::archive
