// SPDX-License-Identifier: BSD-3-Clause
// The checksum of journal records and of texts in the study file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace culm::archive {

/// CRC-32 of ISO 3309 (the one of zip and Ethernet). To continue over a next block, pass the
/// checksum of what came before it.
[[nodiscard]] std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t before = 0);
[[nodiscard]] std::uint32_t crc32(std::string_view text);

} // namespace culm::archive
