// SPDX-License-Identifier: BSD-3-Clause
#include "archive/crc32.hpp"

#include <zlib.h>

namespace culm::archive {

std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t before) {
    return static_cast<std::uint32_t>(
        ::crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

std::uint32_t crc32(std::string_view text) {
    return crc32(std::as_bytes(std::span(text.data(), text.size())));
}

} // namespace culm::archive
