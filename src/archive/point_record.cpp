// SPDX-License-Identifier: BSD-3-Clause
#include "archive/point_record.hpp"

#include "archive/little_endian.hpp"

namespace culm::archive {

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
        throw core::StorageError(std::string(where) + ": bytes left over behind the content");
    return record;
}

} // namespace culm::archive
