// SPDX-License-Identifier: BSD-3-Clause
#include "archive/journal/format.hpp"

#include "archive/bytes.hpp"

#include <algorithm>
#include <utility>

namespace culm::archive {

namespace {

/// Header and payload have a checksum each. An intact header locates the next record even if its
/// payload is damaged, so that one flipped bit destroys only one record.
std::vector<std::byte> encoded_header(std::int64_t point, RecordKind kind,
                                      std::span<const std::byte> payload) {
    ByteWriter header;
    header.put_bytes(record_magic);
    header.put(static_cast<std::uint64_t>(payload.size()));
    header.put(point);
    header.put(static_cast<std::uint32_t>(kind));
    header.put(std::uint32_t{0});
    header.put(crc32(payload));
    header.put(crc32(header.bytes()));
    return header.take();
}

bool is_known_kind(std::uint32_t number) {
    return number <= static_cast<std::uint32_t>(RecordKind::GivenBack) &&
           number != static_cast<std::uint32_t>(PointStatus::Missing);
}

/// The payload (docs/archive-format.md): all members except point and status, which are in the
/// record's header.
void put_payload(const PointRecord& record, ByteWriter& writer) {
    const std::size_t doubles = record.values.size() + record.tip_deflection.size() +
                                record.height_deflection.size() + record.positions.size();
    writer.reserve(64 + record.failure_kind.size() + record.failure_reason.size() +
                   doubles * sizeof(double));
    writer.put_text(record.failure_kind);
    writer.put_text(record.failure_reason);
    writer.put_doubles(record.values);
    writer.put_doubles(record.tip_deflection);
    writer.put_doubles(record.height_deflection);
    writer.put_doubles(record.positions);
}

} // namespace

std::vector<std::byte> encode_journal_header(std::string_view identity) {
    ByteWriter writer;
    writer.put_bytes(std::as_bytes(std::span(journal_magic)));
    writer.put(journal_version);
    writer.put_text(identity);
    writer.put(crc32(writer.bytes()));
    return writer.take();
}

void encode_record(const PointRecord& record, std::vector<std::byte>& bytes) {
    // The payload is encoded behind a gap for the header, whose checksum is known only afterwards.
    // Thus histories are copied only once.
    bytes.resize(record_header_size);
    ByteWriter payload(std::move(bytes));
    put_payload(record, payload);
    bytes = payload.take();
    const auto content = std::span<const std::byte>(bytes).subspan(record_header_size);

    std::ranges::copy(encoded_header(record.point,
                                     record.completed ? RecordKind::Completed : RecordKind::Failed,
                                     content),
                      bytes.begin());
}

void encode_marks(std::span<const std::int64_t> points, RecordKind kind,
                  std::vector<std::byte>& bytes) {
    bytes.clear();
    ByteWriter marks(std::move(bytes));
    for (const std::int64_t point : points)
        marks.put_bytes(encoded_header(point, kind, {}));
    bytes = marks.take();
}

std::optional<RecordHeader> decode_record_header(std::span<const std::byte> bytes) {
    if (bytes.size() < record_header_size ||
        !std::equal(record_magic.begin(), record_magic.end(), bytes.begin()))
        return std::nullopt;
    ByteReader reader(bytes.first(record_header_size).subspan(record_magic.size()), "header");
    RecordHeader header;
    header.payload_size = reader.get<std::uint64_t>();
    header.point = reader.get<std::int64_t>();
    const auto kind = reader.get<std::uint32_t>();
    const auto reserved = reader.get<std::uint32_t>();
    header.payload_crc = reader.get<std::uint32_t>();
    const auto header_crc = reader.get<std::uint32_t>();
    // The checksum is tested first: kind and size of a damaged header are meaningless.
    if (header_crc != crc32(bytes.first(record_header_size - sizeof(header_crc))) ||
        !is_known_kind(kind) || reserved != 0)
        return std::nullopt;
    header.kind = static_cast<RecordKind>(kind);
    return header;
}

PointRecord decode_payload(std::span<const std::byte> payload, std::string_view where) {
    ByteReader reader(payload, where);
    PointRecord record;
    record.failure_kind = reader.get_text();
    record.failure_reason = reader.get_text();
    record.values = reader.get_doubles();
    record.tip_deflection = reader.get_doubles();
    record.height_deflection = reader.get_doubles();
    record.positions = reader.get_doubles();
    if (!reader.is_empty())
        throw core::StorageError(std::string(where) + ": unexpected bytes after the content");
    return record;
}

} // namespace culm::archive
