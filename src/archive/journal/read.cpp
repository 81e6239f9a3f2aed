// SPDX-License-Identifier: BSD-3-Clause
#include "archive/journal/read.hpp"

#include "archive/bytes.hpp"
#include "archive/journal/format.hpp"
#include "core/error.hpp"
#include "core/wire.hpp"

#include <algorithm>
#include <optional>
#include <span>
#include <string_view>
#include <tuple>

#include <fmt/format.h>

namespace culm::archive {

namespace {

/// InputError unless the identity text (the canonical configuration) stored in the file named
/// `where` equals that of the current study. The message shows the first line that differs.
void require_same_study(std::string_view stored, std::string_view current,
                        const std::string& where) {
    if (stored == current)
        return;
    const auto equal_end = std::ranges::mismatch(stored, current).in1;
    const std::string_view equal(stored.begin(), equal_end);
    const std::size_t line_begin = equal.rfind('\n') + 1; // npos + 1 is 0
    const auto line_of = [line_begin](std::string_view text) {
        return text.substr(line_begin, text.find('\n', line_begin) - line_begin);
    };
    throw core::InputError(fmt::format(
        "{} belongs to another study: line {} of the configuration is \"{}\" there and \"{}\" "
        "here; use another output folder, or the unchanged study to resume",
        where, 1 + std::ranges::count(equal, '\n'), line_of(stored), line_of(current)));
}

constexpr std::size_t block_size = std::size_t{1} << 20U;

/// Calls visit(block) for consecutive blocks of [begin, end) until it returns false.
template <class Visit>
void for_each_block(const FileDescriptor& file, std::uint64_t begin, std::uint64_t end,
                    Visit visit) {
    std::vector<std::byte> buffer(
        static_cast<std::size_t>(std::min<std::uint64_t>(block_size, end - begin)));
    while (begin < end) {
        const auto wanted =
            static_cast<std::size_t>(std::min<std::uint64_t>(buffer.size(), end - begin));
        const std::size_t got = file.read_at(std::span(buffer).first(wanted), begin);
        if (got == 0 || !visit(std::span<const std::byte>(buffer).first(got)))
            return;
        begin += got;
    }
}

/// The bytes of the file at the offset; fewer at its end.
std::vector<std::byte> bytes_at(const FileDescriptor& file, std::uint64_t offset,
                                std::uint64_t size) {
    std::vector<std::byte> bytes(static_cast<std::size_t>(size));
    bytes.resize(file.read_at(bytes, offset));
    return bytes;
}

std::optional<RecordHeader> read_record_header(const FileDescriptor& file, std::uint64_t offset,
                                               std::uint64_t file_size) {
    std::optional<RecordHeader> header =
        decode_record_header(bytes_at(file, offset, record_header_size));
    if (header && header->payload_size > file_size - offset - record_header_size)
        header.reset();
    return header;
}

bool payload_is_whole(const FileDescriptor& file, std::uint64_t offset,
                      const RecordHeader& header) {
    const std::uint64_t begin = offset + record_header_size;
    std::uint32_t crc = 0;
    for_each_block(file, begin, begin + header.payload_size,
                   [&crc](std::span<const std::byte> block) {
                       crc = crc32(block, crc);
                       return true;
                   });
    return crc == header.payload_crc;
}

/// Offset of the next record magic at or behind `begin`, or `end`.
std::uint64_t find_record_magic(const FileDescriptor& file, std::uint64_t begin,
                                std::uint64_t end) {
    std::vector<std::byte> buffer(block_size);
    // Blocks overlap, because the magic may lie across the border between two of them.
    constexpr std::size_t overlap = record_magic.size() - 1;
    while (end - begin > overlap) {
        const std::size_t got = file.read_at(buffer, begin);
        const auto stop = buffer.begin() + static_cast<std::ptrdiff_t>(got);
        const auto hit =
            std::search(buffer.begin(), stop, record_magic.begin(), record_magic.end());
        if (hit != stop)
            return begin + static_cast<std::uint64_t>(hit - buffer.begin());
        if (got <= overlap)
            break;
        begin += got - overlap;
    }
    return end;
}

bool is_all_zero(const FileDescriptor& file, std::uint64_t size) {
    bool zero = true;
    for_each_block(file, 0, size, [&zero](std::span<const std::byte> block) {
        zero =
            std::all_of(block.begin(), block.end(), [](std::byte b) { return b == std::byte{}; });
        return zero;
    });
    return zero;
}

/// If a process dies while it creates the journal, the file contains a part of the header or zeros.
/// Any other incomplete header may be followed by records, so the file must be kept.
bool header_was_never_finished(const FileDescriptor& file, std::string_view identity) {
    const std::uint64_t size = file.size();
    const std::vector<std::byte> expected = encode_journal_header(identity);
    const std::vector<std::byte> found = bytes_at(file, 0, std::min(size, expected.size()));
    return (size < expected.size() && std::ranges::equal(found, std::span(expected).first(size))) ||
           is_all_zero(file, size);
}

/// Version and length of the identity behind the magic.
struct JournalPrefix {
    std::uint32_t version = 0;
    std::uint64_t text_size = 0;
};

JournalPrefix prefix_of(std::span<const std::byte> bytes) {
    return core::decoded<JournalPrefix>(
        {bytes.begin() + journal_magic.size(), bytes.begin() + journal_prefix_size});
}

/// Whether the file ends within the header of any study.
bool is_beginning_of_header(const FileDescriptor& file) {
    const std::vector<std::byte> bytes = bytes_at(file, 0, journal_prefix_size);
    const auto magic = std::as_bytes(std::span(journal_magic));
    const std::size_t known = std::min(bytes.size(), magic.size());
    if (!std::ranges::equal(std::span(bytes).first(known), magic.first(known)))
        return false;
    if (bytes.size() < journal_prefix_size)
        return true;
    return prefix_of(bytes).text_size > file.size() - journal_prefix_size;
}

struct HeaderText {
    std::string identity;
    std::uint64_t size = 0; ///< of the whole file header, bytes
};

HeaderText read_header(const FileDescriptor& file) {
    const std::string name = file.path().string();
    std::vector<std::byte> bytes = bytes_at(file, 0, journal_prefix_size);
    const auto magic = std::as_bytes(std::span(journal_magic));
    if (bytes.size() < journal_prefix_size ||
        !std::equal(magic.begin(), magic.end(), bytes.begin()))
        throw core::StorageError(fmt::format("{} is not a culm journal", name));
    const auto [version, text_size] = prefix_of(bytes);
    if (version != journal_version)
        throw core::StorageError(fmt::format(
            "{} has journal format version {}; this culm reads version {}. Continue with the culm "
            "that began the study, or move the file away to compute its points again",
            name, version, journal_version));
    constexpr std::uint64_t around = journal_prefix_size + sizeof(std::uint32_t);
    if (text_size <= file.size() && around <= file.size() - text_size) {
        const std::uint64_t size = around + text_size;
        bytes = bytes_at(file, 0, size);
        const auto body = std::span<const std::byte>(bytes).first(size - sizeof(std::uint32_t));
        const std::span<const std::byte> checksum =
            std::span<const std::byte>(bytes).subspan(body.size());
        if (core::decoded<std::uint32_t>({checksum.begin(), checksum.end()}) == crc32(body))
            return {{reinterpret_cast<const char*>(body.data()) + journal_prefix_size, text_size},
                    size};
    }
    throw core::StorageError(fmt::format(
        "{}: the header is damaged, so its study is unknown; move the file away to continue "
        "without its points",
        name));
}

/// Adds an intact record to the scan.
void note_record(const RecordHeader& header, std::uint64_t offset, std::uint64_t length,
                 JournalScan& scan) {
    if (is_outcome(header.kind))
        scan.entries.push_back(
            {header.point,
             header.kind == RecordKind::Completed ? PointStatus::Completed : PointStatus::Failed,
             offset, length});
    if (header.kind == RecordKind::Started) {
        ++scan.unfinished_starts[header.point];
        return;
    }
    // An outcome or a mark "given back" cancels one start. Each remaining start means that a
    // process died while it computed the point.
    const auto start = scan.unfinished_starts.find(header.point);
    if (start != scan.unfinished_starts.end() && --start->second == 0)
        scan.unfinished_starts.erase(start);
}

/// Walks over the records behind the header and fills the scan.
void scan_records(const FileDescriptor& file, ScanDepth depth, JournalScan& scan) {
    const std::uint64_t size = scan.size;
    std::uint64_t offset = scan.valid_end;
    // The scan never throws for damage behind the header, because it must find every intact record.
    while (offset < size) {
        const std::optional<RecordHeader> header = read_record_header(file, offset, size);
        if (!header ||
            (depth == ScanDepth::Everything && !payload_is_whole(file, offset, *header))) {
            // The length in a damaged record is not reliable, so the search looks for the next
            // magic. A payload may contain the magic by chance; the checksum of that header is then
            // wrong and the search continues.
            scan.corrupt_records += header ? 1 : 0;
            offset = find_record_magic(file, offset + 1, size);
            continue;
        }
        // An intact record follows the damage, so the damage is not an interrupted last write.
        if (offset > scan.valid_end) {
            ++scan.damaged_regions;
            scan.skipped_bytes += offset - scan.valid_end;
        }
        const std::uint64_t length = record_header_size + header->payload_size;
        note_record(*header, offset, length, scan);
        offset += length;
        scan.valid_end = offset;
    }
    scan.torn_tail_bytes = size - scan.valid_end;
}

/// Processes may open some 1000 files; MPI needs its share of them.
constexpr std::size_t most_open_files = 64;

} // namespace

JournalScan scan_journal(const FileDescriptor& file, std::string_view identity, ScanDepth depth) {
    JournalScan scan;
    scan.file = file.path().string();
    scan.size = file.size();
    if (header_was_never_finished(file, identity)) {
        scan.header_finished = false;
        scan.torn_tail_bytes = scan.size;
        return scan;
    }
    const HeaderText header = read_header(file);
    require_same_study(header.identity, identity, scan.file);
    scan.valid_end = header.size;
    scan_records(file, depth, scan);
    return scan;
}

JournalScan scan_journal(const std::filesystem::path& path, std::string_view identity,
                         ScanDepth depth) {
    return scan_journal(FileDescriptor(path, FileDescriptor::Access::Read), identity, depth);
}

std::vector<std::filesystem::path> journal_files(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> files;
    std::error_code error;
    if (!std::filesystem::exists(folder, error))
        return {};
    for (const auto& entry : std::filesystem::directory_iterator(folder, error))
        if (entry.path().extension() == ".culmj")
            files.push_back(entry.path());
    if (error)
        throw_storage_error("list", folder, error.value());
    std::sort(files.begin(), files.end());
    return files;
}

std::vector<JournalScan> scan_journal_folder(const std::filesystem::path& folder,
                                             std::string_view identity) {
    std::vector<JournalScan> scans;
    for (const std::filesystem::path& file : journal_files(folder))
        scans.push_back(scan_journal(file, identity));
    return scans;
}

std::optional<std::string> read_journal_identity(const std::filesystem::path& path) {
    const FileDescriptor file(path, FileDescriptor::Access::Read);
    try {
        return read_header(file).identity;
    } catch (const core::StorageError&) {
        // An unfinished header cannot contain a complete text.
        if (is_all_zero(file, file.size()) || is_beginning_of_header(file))
            return std::nullopt;
        throw;
    }
}

PointRecord read_record(const FileDescriptor& file, const JournalEntry& entry) {
    const std::string where =
        fmt::format("{}, record at byte {}", file.path().string(), entry.offset);
    const std::vector<std::byte> bytes = bytes_at(file, entry.offset, entry.length);
    const std::optional<RecordHeader> header = decode_record_header(bytes);
    // The study may be running: another process may have truncated the journal since the scan.
    if (!header || header->point != entry.point ||
        bytes.size() != record_header_size + header->payload_size)
        throw core::StorageError(where + ": the record has changed since the journal was scanned");
    const auto payload = std::span<const std::byte>(bytes).subspan(record_header_size);
    if (crc32(payload) != header->payload_crc)
        throw core::StorageError(where + ": the payload does not match its checksum");
    PointRecord record = decode_payload(payload, where);
    record.point = header->point;
    record.completed = header->kind == RecordKind::Completed;
    return record;
}

void discard_record(const std::filesystem::path& journal, const JournalEntry& entry) {
    constexpr std::array<std::byte, record_magic.size()> nothing{};
    FileDescriptor file(journal, FileDescriptor::Access::ReadWriteCreate);
    file.write_at(nothing, entry.offset);
    file.sync_data();
}

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
    // The entry to be used is the last one of its point; only that one is kept.
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

std::optional<PointRecord> JournalIndex::find_record(std::int64_t point) {
    const Place* place = find(point);
    if (place == nullptr)
        return std::nullopt;
    auto file = open_.find(place->file);
    if (file == open_.end()) {
        // Only studies on more ranks than this reach this line. Points are read in order and each
        // rank computed a share of all of them, so any of the files may be closed.
        if (open_.size() == most_open_files)
            open_.clear();
        file =
            open_.try_emplace(place->file, files_[place->file], FileDescriptor::Access::Read).first;
    }
    return read_record(file->second, place->entry);
}

} // namespace culm::archive
