// SPDX-License-Identifier: BSD-3-Clause
// Chunks that culm filters itself are what HDF5's own filters take.
#include "archive/chunk_filter.hpp"

#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <string_view>

#include <gtest/gtest.h>
#include <zlib.h>

namespace culm::archive {
namespace {

std::span<const std::byte> bytes_of(std::string_view text) {
    return std::as_bytes(std::span(text.data(), text.size()));
}

/// H5_checksum_fletcher32 of HDF5 1.10 with sums that cannot overflow.
std::uint32_t fletcher32_by_definition(std::span<const std::byte> bytes) {
    std::uint64_t sum = 0;
    std::uint64_t sum_of_sums = 0;
    for (std::size_t i = 0; i < bytes.size(); i += 2) {
        const auto high = std::to_integer<std::uint64_t>(bytes[i]);
        const auto low = i + 1 < bytes.size() ? std::to_integer<std::uint64_t>(bytes[i + 1]) : 0;
        sum += 256 * high + low;
        sum_of_sums += sum;
    }
    // Ones' complement: a sum that is not zero is never reduced to zero.
    const auto reduced = [](std::uint64_t n) { return n == 0 ? 0 : (n - 1) % 65535 + 1; };
    return static_cast<std::uint32_t>(reduced(sum_of_sums) << 16U | reduced(sum));
}

TEST(Fletcher32, EqualsItsDefinitionForEveryLength) {
    std::mt19937 random(1);
    std::vector<std::byte> bytes(1500); // two blocks of 512 bytes and a half
    for (std::byte& byte : bytes)
        byte = static_cast<std::byte>(random());
    for (std::size_t size = 0; size <= bytes.size(); ++size) {
        const auto part = std::span<const std::byte>(bytes).first(size);
        ASSERT_EQ(fletcher32(part), fletcher32_by_definition(part)) << size;
    }
}

TEST(Fletcher32, HoldsTheLargestSums) {
    const std::vector<std::byte> bytes(100'000, std::byte{0xFF});
    EXPECT_EQ(fletcher32(bytes), fletcher32_by_definition(bytes));
    EXPECT_EQ(fletcher32(std::vector<std::byte>(1000)), 0U);
}

TEST(Fletcher32, HasTheValueOfHdf5sOwnTest) {
    // test/tchecksum.c of HDF5: four bytes ab, cd, ef, 01 … there as "0x42 …"; here by hand:
    // words 0x6162, 0x6364: sums 0xC4C6 and 0x6162 + 0xC4C6 = 0x12628 -> 0x2629.
    EXPECT_EQ(fletcher32(bytes_of("abcd")), 0x2629C4C6U);
}

/// Undoes the filters one by one; fails on a wrong checksum.
std::vector<double> unfiltered(std::span<const std::byte> stored, std::size_t count,
                               bool is_compressed) {
    const auto body = stored.first(stored.size() - 4);
    std::uint32_t checksum = 0;
    for (std::size_t k = 0; k < 4; ++k)
        checksum |= std::to_integer<std::uint32_t>(stored[body.size() + k]) << (8 * k);
    EXPECT_EQ(checksum, fletcher32(body));
    std::vector<double> values(count);
    if (!is_compressed) {
        EXPECT_EQ(body.size(), 8 * count);
        std::memcpy(values.data(), body.data(), body.size());
        return values;
    }
    std::vector<unsigned char> planes(8 * count);
    uLongf size = planes.size();
    EXPECT_EQ(
        uncompress(planes.data(), &size, reinterpret_cast<const Bytef*>(body.data()), body.size()),
        Z_OK);
    EXPECT_EQ(size, 8 * count);
    std::vector<unsigned char> bytes(8 * count);
    for (std::size_t i = 0; i < bytes.size(); ++i)
        bytes[i] = planes[i % 8 * count + i / 8];
    std::memcpy(values.data(), bytes.data(), bytes.size());
    return values;
}

/// Histories of every kind: smooth, noise, constant, NaN, and mixed.
std::vector<std::vector<double>> histories(std::size_t size) {
    std::mt19937_64 random(3);
    std::vector<double> smooth(size);
    std::vector<double> noise(size);
    std::vector<double> mixed(size);
    for (std::size_t k = 0; k < size; ++k) {
        const auto t = static_cast<double>(k);
        smooth[k] = 0.015 * std::exp(-1e-3 * t) * std::cos(0.02 * t);
        noise[k] = std::bit_cast<double>(random() & 0x7FEFFFFFFFFFFFFFU);
        mixed[k] = k % 3 == 0 ? 0.0 : smooth[k];
    }
    return {smooth, noise, mixed, std::vector<double>(size, 1.0),
            std::vector<double>(size, std::numeric_limits<double>::quiet_NaN())};
}

TEST(ChunkFilter, IsUndoneByTheFiltersOfHdf5) {
    for (const int compression : {0, 1, 6, 9}) {
        ChunkFilter filter(compression); // one for all: nothing of a chunk stays behind
        for (const std::size_t size : {1U, 7U, 2001U, 60'000U})
            for (const std::vector<double>& values : histories(size)) {
                const std::vector<double> back =
                    unfiltered(filter.apply(values), size, compression > 0);
                ASSERT_EQ(std::memcmp(back.data(), values.data(), 8 * size), 0)
                    << "compression " << compression << ", " << size << " values";
            }
    }
}

TEST(ChunkFilter, TheSameValuesGiveTheSameBytesWhateverCameBefore) {
    ChunkFilter fresh(1);
    ChunkFilter used(1);
    const auto all = histories(2001);
    for (const std::vector<double>& values : all)
        (void)used.apply(values);
    for (const std::vector<double>& values : all) {
        ChunkFilter first(1);
        const auto expected = first.apply(values);
        const auto found = used.apply(values);
        EXPECT_TRUE(std::equal(expected.begin(), expected.end(), found.begin(), found.end()));
    }
}

TEST(ChunkFilter, CompressesAsWellAsDeflateOfEverything) {
    ChunkFilter filter(1);
    for (const std::vector<double>& values : histories(2001)) {
        const auto size = static_cast<double>(filter.apply(values).size());
        std::vector<unsigned char> planes(8 * values.size());
        const auto* bytes = reinterpret_cast<const unsigned char*>(values.data());
        for (std::size_t i = 0; i < planes.size(); ++i)
            planes[i % 8 * values.size() + i / 8] = bytes[i];
        uLongf plain = compressBound(planes.size());
        std::vector<unsigned char> out(plain);
        ASSERT_EQ(compress2(out.data(), &plain, planes.data(), planes.size(), 1), Z_OK);
        // 1 %: the price of ending a block at a change of level, and of planes judged by samples.
        EXPECT_LT(size, 1.01 * static_cast<double>(plain) + 100.0);
    }
}

} // namespace
} // namespace culm::archive
