// SPDX-License-Identifier: BSD-3-Clause
#include "core/decimal_text.hpp"

#include <bit>
#include <cmath>
#include <cstdint>
#include <random>

#include <gtest/gtest.h>

namespace {

using culm::core::decimal_text;
using culm::core::parse_decimal;
using culm::core::with_point_moved;

TEST(DecimalText, MovesThePointWithoutRounding) {
    EXPECT_EQ(parse_decimal("0.1820", -3), 1.82e-4);
    EXPECT_EQ(parse_decimal("-17.6e1", -3), -0.176);
    EXPECT_EQ(parse_decimal("+2.83", -3), 2.83e-3);
    EXPECT_EQ(with_point_moved(2.83, -3), 2.83e-3);
    // A multiplication would be off by a rounding here.
    EXPECT_NE(0.017 * 1e-3, 1.7e-5 + 1e-21);
    EXPECT_EQ(with_point_moved(1.7e-5, 3), 0.017);
}

TEST(DecimalText, IsPlainAndShort) {
    EXPECT_EQ(decimal_text(0.0), "0");
    EXPECT_EQ(decimal_text(-0.25), "-0.25");
    EXPECT_EQ(decimal_text(1.82e-4, 3), "0.182");
    EXPECT_EQ(decimal_text(0.148, 3), "148");
    EXPECT_EQ(decimal_text(960.0), "960");
    EXPECT_EQ(decimal_text(5e-8, 0), "5e-8");
    EXPECT_EQ(decimal_text(1.25e20), "1.25e20");
}

TEST(DecimalText, RefusesTextThatIsNotAFiniteDecimalNumber) {
    for (const char* text :
         {"", "+", "-", "1,5", "1.5mm", "1.5 ", "inf", "nan", "0x10", "1e999", "+-1"})
        EXPECT_FALSE(parse_decimal(text)) << text;
    EXPECT_FALSE(parse_decimal("1e308", 3));
}

TEST(DecimalText, ReadsBackBitForBitWhateverTheNumberAndTheUnit) {
    std::mt19937_64 random(7);
    for (int i = 0; i < 20000; ++i) {
        const double value = std::bit_cast<double>(random());
        // Beyond these the other unit has no finite normal number.
        if (!std::isfinite(value) || std::abs(value) > 1e290 || std::abs(value) < 1e-290)
            continue;
        for (const int power : {0, 3, -3}) {
            const auto back = parse_decimal(decimal_text(value, power), -power);
            ASSERT_TRUE(back);
            ASSERT_EQ(std::bit_cast<std::uint64_t>(*back), std::bit_cast<std::uint64_t>(value));
        }
    }
}

} // namespace
