// SPDX-License-Identifier: BSD-3-Clause
// The checksum of bytes: CRC-32 of ISO 3309 (zip, Ethernet).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include <libdeflate.h>

namespace culm::archive {

/// Continued from the CRC-32 of the preceding bytes.
[[nodiscard]] inline std::uint32_t crc32(std::span<const std::byte> bytes,
                                         std::uint32_t before = 0) {
    return ::libdeflate_crc32(before, bytes.data(), bytes.size());
}

[[nodiscard]] inline std::uint32_t crc32(std::string_view text) {
    return crc32(std::as_bytes(std::span(text.data(), text.size())));
}

} // namespace culm::archive
