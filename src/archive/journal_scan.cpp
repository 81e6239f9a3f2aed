// SPDX-License-Identifier: BSD-3-Clause
#include "archive/journal_scan.hpp"

#include "archive/crc32.hpp"
#include "archive/identity.hpp"
#include "archive/journal_format.hpp"
#include "archive/little_endian.hpp"
#include "core/error.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <utility>

#include <fmt/format.h>

namespace culm::archive {

namespace {

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

std::optional<RecordHeader> read_record_header(const FileDescriptor& file, std::uint64_t offset,
                                               std::uint64_t file_size) {
    std::array<std::byte, record_header_size> bytes{};
    const std::size_t got = file.read_at(bytes, offset);
    std::optional<RecordHeader> header = decode_record_header(std::span(bytes).first(got));
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

/// A process that died while it created the journal leaves a part of the header or zeros. Anything
/// else that is no whole header may have records behind it and must not be thrown away.
bool header_was_never_finished(const FileDescriptor& file, std::string_view identity) {
    const std::uint64_t size = file.size();
    for (std::uint32_t version = oldest_journal_version; version <= journal_version; ++version) {
        const std::vector<std::byte> expected = encode_journal_header(identity, version);
        if (size >= expected.size())
            continue;
        std::vector<std::byte> found(static_cast<std::size_t>(size));
        const std::size_t got = file.read_at(found, 0);
        if (std::equal(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(got),
                       expected.begin()))
            return true;
    }
    return is_all_zero(file, size);
}

/// Whether the file ends within a header, whatever its study.
bool is_beginning_of_header(const FileDescriptor& file) {
    std::vector<std::byte> bytes(journal_prefix_size);
    bytes.resize(file.read_at(bytes, 0));
    const auto magic = std::as_bytes(std::span(journal_magic));
    if (!std::equal(bytes.begin(),
                    bytes.begin() +
                        static_cast<std::ptrdiff_t>(std::min(bytes.size(), magic.size())),
                    magic.begin()))
        return false;
    if (bytes.size() < journal_prefix_size)
        return true;
    ByteReader prefix(std::span<const std::byte>(bytes).subspan(magic.size()), "header");
    (void)prefix.get<std::uint32_t>();
    return journal_prefix_size + std::uint64_t{prefix.get<std::uint32_t>()} > file.size();
}

struct HeaderText {
    std::string identity;
    std::uint64_t size = 0; ///< of the whole file header, bytes
};

HeaderText read_header(const FileDescriptor& file) {
    const std::string name = file.path().string();
    std::vector<std::byte> bytes(journal_prefix_size);
    bytes.resize(file.read_at(bytes, 0));
    const auto magic = std::as_bytes(std::span(journal_magic));
    if (bytes.size() < journal_prefix_size ||
        !std::equal(magic.begin(), magic.end(), bytes.begin()))
        throw core::StorageError(fmt::format("{} is not a culm journal", name));
    ByteReader prefix(std::span<const std::byte>(bytes).subspan(magic.size()), name);
    const auto version = prefix.get<std::uint32_t>();
    if (version < oldest_journal_version || version > journal_version)
        throw core::StorageError(fmt::format(
            "{} has journal format version {}; this culm reads versions {} to {}. Go on "
            "with the culm that began the study, or move the file away to compute its "
            "points again",
            name, version, oldest_journal_version, journal_version));
    const auto text_size = prefix.get<std::uint32_t>();
    const std::uint64_t size = journal_prefix_size + std::uint64_t{text_size} + sizeof(version);
    if (size <= file.size()) {
        bytes.resize(static_cast<std::size_t>(size));
        bytes.resize(file.read_at(bytes, 0));
        ByteReader reader(std::span<const std::byte>(bytes).subspan(magic.size() + sizeof(version)),
                          name);
        HeaderText header{reader.get_text(), size};
        const auto body = std::span<const std::byte>(bytes).first(bytes.size() - sizeof(version));
        if (reader.get<std::uint32_t>() == crc32(body))
            return header;
    }
    throw core::StorageError(fmt::format(
        "{}: the header is damaged, so its study is unknown; move the file away to go on without "
        "its points",
        name));
}

/// Adds a whole record to what the scan knows of its point.
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
    const auto start = scan.unfinished_starts.find(header.point);
    if (start != scan.unfinished_starts.end() && --start->second == 0)
        scan.unfinished_starts.erase(start);
}

/// Walks over the records behind the header and fills the scan.
void scan_records(const FileDescriptor& file, ScanDepth depth, JournalScan& scan) {
    const std::uint64_t size = scan.size;
    std::uint64_t offset = scan.valid_end;
    while (offset < size) {
        const std::optional<RecordHeader> header = read_record_header(file, offset, size);
        if (!header ||
            (depth == ScanDepth::Everything && !payload_is_whole(file, offset, *header))) {
            scan.corrupt_records += header ? 1 : 0;
            offset = find_record_magic(file, offset + 1, size);
            continue;
        }
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
        // Of a header that was never finished no whole text can be in the file.
        if (is_all_zero(file, file.size()) || is_beginning_of_header(file))
            return std::nullopt;
        throw;
    }
}

PointRecord read_record(const FileDescriptor& file, const JournalEntry& entry) {
    const std::string where =
        fmt::format("{}, record at byte {}", file.path().string(), entry.offset);
    std::vector<std::byte> bytes(static_cast<std::size_t>(entry.length));
    bytes.resize(file.read_at(bytes, entry.offset));
    const std::optional<RecordHeader> header = decode_record_header(bytes);
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

} // namespace culm::archive
