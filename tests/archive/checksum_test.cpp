// SPDX-License-Identifier: BSD-3-Clause
#include "archive/crc32.hpp"

#include <gtest/gtest.h>

namespace culm::archive {
namespace {

TEST(Crc32, HasTheCheckValueOfTheCatalogue) {
    // "check" entry of CRC-32/ISO-HDLC in the catalogue of parametrised CRC algorithms.
    EXPECT_EQ(crc32(std::string_view("123456789")), 0xCBF43926U);
}

TEST(Crc32, OfPartsContinuedEqualsThatOfTheWhole) {
    const std::string_view text = "a text that is cut at every place";
    const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
    for (std::size_t cut = 0; cut <= bytes.size(); ++cut)
        EXPECT_EQ(crc32(bytes.subspan(cut), crc32(bytes.first(cut))), crc32(text)) << cut;
}

} // namespace
} // namespace culm::archive
