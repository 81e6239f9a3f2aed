// SPDX-License-Identifier: BSD-3-Clause
// The bytes of a journal: file header and record headers (docs/archive-format.md, journal 4).
#pragma once

#include "archive/point_record.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace culm::archive {

inline constexpr std::uint32_t journal_version = 4;
inline constexpr std::array<char, 8> journal_magic = {'C', 'U', 'L', 'M', 'J', 'R', 'N', 'L'};
/// Bytes of the file header before the identity text: magic, version, length.
inline constexpr std::size_t journal_prefix_size = 20;

/// The first bytes of every record. Neither texts nor likely doubles contain them, so that a search
/// for them rarely finds anything else.
inline constexpr std::array<std::byte, 8> record_magic = {
    std::byte{0xC5}, std::byte{'R'},  std::byte{'E'},  std::byte{'C'},
    std::byte{0x0D}, std::byte{0x0A}, std::byte{0x1A}, std::byte{0xF1}};
inline constexpr std::size_t record_header_size = 40;

/// Kind of a record, with the numbers used in the file. No journal contains 2, which is
/// PointStatus::Missing.
enum class RecordKind : std::uint8_t {
    Completed = 0,
    Failed = 1,
    Started = 3,   ///< mark without payload: a rank begins to compute the point
    GivenBack = 4, ///< mark without payload: the rank stopped before it had an outcome
};

[[nodiscard]] constexpr bool is_outcome(RecordKind kind) {
    return kind == RecordKind::Completed || kind == RecordKind::Failed;
}

struct RecordHeader {
    std::int64_t point = 0;
    RecordKind kind = RecordKind::Completed;
    std::uint64_t payload_size = 0; ///< bytes
    std::uint32_t payload_crc = 0;
};

/// Magic, version, length and text of the study's identity, CRC-32 of all that.
[[nodiscard]] std::vector<std::byte> encode_journal_header(std::string_view identity);

/// Header and payload of a record in one block, ready for one write.
[[nodiscard]] std::vector<std::byte> encode_record(const PointRecord& record);

/// One mark of this kind for each point, in one block.
[[nodiscard]] std::vector<std::byte> encode_marks(std::span<const std::int64_t> points,
                                                  RecordKind kind);

/// The header in these record_header_size bytes; nothing if magic or checksum is wrong.
[[nodiscard]] std::optional<RecordHeader> decode_record_header(std::span<const std::byte> bytes);

/// Fills all but point and status from a payload. StorageError, beginning with `where`, if the
/// bytes do not have the documented form.
[[nodiscard]] PointRecord decode_payload(std::span<const std::byte> payload,
                                         std::string_view where);

} // namespace culm::archive
