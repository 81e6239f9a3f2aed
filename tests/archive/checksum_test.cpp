// SPDX-License-Identifier: BSD-3-Clause
#include "archive/bytes.hpp"

#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace culm::archive {
namespace {

TEST(Crc32, HasTheCheckValueOfTheCatalogue) {
    // "check" entry of CRC-32/ISO-HDLC in the catalogue of parametrised CRC algorithms.
    EXPECT_EQ(crc32(std::string_view("123456789")), 0xCBF43926U);
}

/// The definition: division of polynomials, bit by bit.
std::uint32_t crc32_by_division(std::span<const std::byte> bytes) {
    std::uint32_t remainder = 0xFFFFFFFFU;
    for (const std::byte byte : bytes) {
        remainder ^= std::to_integer<std::uint32_t>(byte);
        for (int bit = 0; bit < 8; ++bit)
            remainder = (remainder >> 1U) ^ ((remainder & 1U) != 0 ? 0xEDB88320U : 0U);
    }
    return ~remainder;
}

TEST(Crc32, EqualsTheDivisionOfPolynomialsForEveryLengthAndAlignment) {
    // Longer than three of the 64-byte strides in which long texts are processed.
    std::vector<std::byte> bytes(300);
    std::mt19937 random(1);
    for (std::byte& byte : bytes)
        byte = static_cast<std::byte>(random());
    for (std::size_t begin = 0; begin < 9; ++begin)
        for (std::size_t size = 0; begin + size <= bytes.size(); ++size) {
            const auto part = std::span<const std::byte>(bytes).subspan(begin, size);
            ASSERT_EQ(crc32(part), crc32_by_division(part)) << begin << ", " << size;
        }
}

TEST(Crc32, GivesTheSameValueInLongPartsAsAtOnce) {
    std::vector<std::byte> bytes(1000);
    std::mt19937 random(2);
    for (std::byte& byte : bytes)
        byte = static_cast<std::byte>(random());
    const std::span<const std::byte> all(bytes);
    for (std::size_t cut = 0; cut <= bytes.size(); cut += 7)
        ASSERT_EQ(crc32(all.subspan(cut), crc32(all.first(cut))), crc32(all)) << cut;
}

TEST(Crc32, GivesTheSameValueInPartsAsAtOnce) {
    const std::string_view text = "a text that is cut at every place";
    const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
    for (std::size_t cut = 0; cut <= bytes.size(); ++cut)
        EXPECT_EQ(crc32(bytes.subspan(cut), crc32(bytes.first(cut))), crc32(text)) << cut;
}

} // namespace
} // namespace culm::archive
