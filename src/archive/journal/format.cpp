// SPDX-License-Identifier: BSD-3-Clause
#include "archive/journal/format.hpp"

#include "archive/bytes.hpp"
#include "core/error.hpp"
#include "core/wire.hpp"

#include <algorithm>
#include <bit>
#include <string>

#include <fmt/format.h>

namespace culm::archive {

static_assert(std::endian::native == std::endian::little, "numbers are written as they are");

namespace {

/// The bytes and their checksum.
core::Bytes with_checksum(core::Bytes bytes) {
    const core::Bytes checksum = core::encoded(crc32(bytes));
    bytes.insert(bytes.end(), checksum.begin(), checksum.end());
    return bytes;
}

/// Header and payload have a checksum each. An intact header locates the next record even if its
/// payload is damaged, so that one flipped bit destroys only one record.
core::Bytes encoded_header(std::int64_t point, RecordKind kind,
                           std::span<const std::byte> payload) {
    core::WireWriter header;
    header(record_magic, std::uint64_t{payload.size()}, point, static_cast<std::uint32_t>(kind),
           std::uint32_t{0}, crc32(payload));
    return with_checksum(header.take());
}

bool is_known_kind(std::uint32_t number) {
    return number <= static_cast<std::uint32_t>(RecordKind::GivenBack) &&
           number != static_cast<std::uint32_t>(PointStatus::Missing);
}

} // namespace

std::vector<std::byte> encode_journal_header(std::string_view identity) {
    core::WireWriter header;
    header(journal_magic, journal_version, std::string(identity));
    return with_checksum(header.take());
}

std::vector<std::byte> encode_record(const PointRecord& record) {
    core::Bytes bytes = core::encoded(record);
    const core::Bytes header = encoded_header(
        record.point, record.completed ? RecordKind::Completed : RecordKind::Failed, bytes);
    bytes.insert(bytes.begin(), header.begin(), header.end());
    return bytes;
}

std::vector<std::byte> encode_marks(std::span<const std::int64_t> points, RecordKind kind) {
    core::Bytes bytes;
    for (const std::int64_t point : points) {
        const core::Bytes mark = encoded_header(point, kind, {});
        bytes.insert(bytes.end(), mark.begin(), mark.end());
    }
    return bytes;
}

std::optional<RecordHeader> decode_record_header(std::span<const std::byte> bytes) {
    if (bytes.size() < record_header_size ||
        !std::equal(record_magic.begin(), record_magic.end(), bytes.begin()))
        return std::nullopt;
    bytes = bytes.first(record_header_size);
    core::WireReader reader({bytes.begin() + record_magic.size(), bytes.end()});
    RecordHeader header;
    std::uint32_t kind = 0;
    std::uint32_t reserved = 0;
    std::uint32_t header_crc = 0;
    reader(header.payload_size, header.point, kind, reserved, header.payload_crc, header_crc);
    // The checksum is tested first: kind and size of a damaged header are meaningless.
    if (header_crc != crc32(bytes.first(record_header_size - sizeof(header_crc))) ||
        !is_known_kind(kind) || reserved != 0)
        return std::nullopt;
    header.kind = static_cast<RecordKind>(kind);
    return header;
}

PointRecord decode_payload(std::span<const std::byte> payload, std::string_view where) {
    try {
        return core::decoded<PointRecord>({payload.begin(), payload.end()});
    } catch (const core::WireError&) {
        throw core::StorageError(
            fmt::format("{}: the content does not have the lengths that it states", where));
    }
}

} // namespace culm::archive
