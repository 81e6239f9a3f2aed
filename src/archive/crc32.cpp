// SPDX-License-Identifier: BSD-3-Clause
#include "archive/crc32.hpp"

#include <boost/crc.hpp>

namespace culm::archive {

std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t before) {
    // Boost takes the register as it was before reflection and the final exclusive or. The checksum
    // of nothing, 0, becomes the register's initial value in the same way.
    constexpr std::uint32_t final_xor = 0xFFFFFFFFU;
    std::uint32_t reflected = before ^ final_xor;
    std::uint32_t remainder = 0;
    for (int bit = 0; bit < 32; ++bit) {
        remainder = (remainder << 1U) | (reflected & 1U);
        reflected >>= 1U;
    }
    boost::crc_32_type sum;
    sum.reset(remainder);
    sum.process_bytes(bytes.data(), bytes.size());
    return sum.checksum();
}

std::uint32_t crc32(std::string_view text) {
    return crc32(std::as_bytes(std::span(text.data(), text.size())));
}

} // namespace culm::archive
