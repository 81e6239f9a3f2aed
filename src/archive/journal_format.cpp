// SPDX-License-Identifier: BSD-3-Clause
#include "archive/journal_format.hpp"

#include "archive/crc32.hpp"
#include "archive/little_endian.hpp"

#include <algorithm>
#include <utility>

namespace culm::archive {

std::vector<std::byte> encode_journal_header(std::string_view identity) {
    ByteWriter writer;
    writer.put_bytes(std::as_bytes(std::span(journal_magic)));
    writer.put(journal_version);
    writer.put_text(identity);
    writer.put(crc32(writer.bytes()));
    return {writer.bytes().begin(), writer.bytes().end()};
}

void encode_record(const PointRecord& record, std::vector<std::byte>& bytes) {
    bytes.resize(record_header_size);
    ByteWriter payload(std::move(bytes));
    put_payload(record, payload);
    bytes = payload.take();
    const auto content = std::span<const std::byte>(bytes).subspan(record_header_size);

    ByteWriter header;
    header.put_bytes(record_magic);
    header.put(static_cast<std::uint64_t>(content.size()));
    header.put(record.point);
    header.put(static_cast<std::uint32_t>(record.status()));
    header.put(std::uint32_t{0});
    header.put(crc32(content));
    header.put(crc32(header.bytes()));
    std::copy(header.bytes().begin(), header.bytes().end(), bytes.begin());
}

std::optional<RecordHeader> decode_record_header(std::span<const std::byte> bytes) {
    if (bytes.size() < record_header_size ||
        !std::equal(record_magic.begin(), record_magic.end(), bytes.begin()))
        return std::nullopt;
    ByteReader reader(bytes.first(record_header_size).subspan(record_magic.size()), "header");
    RecordHeader header;
    header.payload_size = reader.get<std::uint64_t>();
    header.point = reader.get<std::int64_t>();
    const auto status = reader.get<std::uint32_t>();
    const auto reserved = reader.get<std::uint32_t>();
    header.payload_crc = reader.get<std::uint32_t>();
    const auto header_crc = reader.get<std::uint32_t>();
    if (header_crc != crc32(bytes.first(record_header_size - sizeof(header_crc))) || status > 1 ||
        reserved != 0)
        return std::nullopt;
    header.status = static_cast<PointStatus>(status);
    return header;
}

} // namespace culm::archive
