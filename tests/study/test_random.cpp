// SPDX-License-Identifier: BSD-3-Clause
// The counter-based generator.
#include "study/design/sampling.hpp"

#include <gtest/gtest.h>

namespace culm::study {
namespace {

TEST(Random, BitsAreThePublishedPhilox) {
    // Known answer of philox4x64-10 for counter 0 and key 0, from the test vectors of Random123.
    const RandomKey zero{0, static_cast<RandomPurpose>(0), 0, 0, 0};
    EXPECT_EQ(random_bits(zero), 0x16554d9eca36314cU);
}

TEST(Random, UniformsNeverReachTheEnds) {
    EXPECT_EQ(open_unit_interval(0), 0x1p-54);
    EXPECT_LT(open_unit_interval(~std::uint64_t{0}), 1.0);
    EXPECT_EQ(open_unit_interval(std::uint64_t{1} << 63), 0.5);
}

TEST(Random, EveryPartOfTheKeyMatters) {
    const RandomKey key{1, RandomPurpose::Draw, factor_id("length_mm"), 0, 0};
    RandomKey other = key;
    other.seed = 2;
    EXPECT_NE(random_bits(key), random_bits(other));
    other = key;
    other.purpose = RandomPurpose::Permutation;
    EXPECT_NE(random_bits(key), random_bits(other));
    other = key;
    other.factor = factor_id("bond_damping");
    EXPECT_NE(random_bits(key), random_bits(other));
    other = key;
    other.replicate = 1;
    EXPECT_NE(random_bits(key), random_bits(other));
    other = key;
    other.point = 1;
    EXPECT_NE(random_bits(key), random_bits(other));
}

} // namespace
} // namespace culm::study
