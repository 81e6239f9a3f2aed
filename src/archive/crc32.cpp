// SPDX-License-Identifier: BSD-3-Clause
#include "archive/crc32.hpp"

#include <array>
#include <bit>
#include <cstring>

#if defined(__PCLMUL__) && defined(__SSE4_1__)
#include <immintrin.h>
#endif

namespace culm::archive {

namespace {

constexpr std::uint32_t reflected_polynomial = 0xEDB88320U;
constexpr std::size_t slices = 8;

/// tables[k][b]: what byte b contributes when k more bytes follow it.
using Tables = std::array<std::array<std::uint32_t, 256>, slices>;

constexpr Tables make_tables() {
    Tables tables{};
    for (std::uint32_t byte = 0; byte < 256; ++byte) {
        std::uint32_t remainder = byte;
        for (int bit = 0; bit < 8; ++bit)
            remainder = (remainder >> 1U) ^ ((remainder & 1U) != 0 ? reflected_polynomial : 0U);
        tables[0][byte] = remainder;
    }
    for (std::size_t k = 1; k < slices; ++k)
        for (std::size_t byte = 0; byte < 256; ++byte) {
            const std::uint32_t before = tables[k - 1][byte];
            tables[k][byte] = (before >> 8U) ^ tables[0][before & 0xFFU];
        }
    return tables;
}

constexpr Tables tables = make_tables();

std::uint32_t update_byte(std::uint32_t remainder, std::byte byte) {
    return (remainder >> 8U) ^
           tables[0][(remainder ^ std::to_integer<std::uint32_t>(byte)) & 0xFFU];
}

/// Eight bytes at a time (Kounavis & Berry 2008, "Novel table lookup-based algorithms for
/// high-performance CRC generation").
std::uint32_t update_by_tables(std::uint32_t remainder, std::span<const std::byte> bytes) {
    if constexpr (std::endian::native == std::endian::little) {
        for (; bytes.size() >= slices; bytes = bytes.subspan(slices)) {
            std::uint64_t word = 0;
            std::memcpy(&word, bytes.data(), sizeof word);
            word ^= remainder;
            remainder = 0;
            for (std::size_t k = 0; k < slices; ++k)
                remainder ^= tables[slices - 1 - k][(word >> (8 * k)) & 0xFFU];
        }
    }
    for (const std::byte byte : bytes)
        remainder = update_byte(remainder, byte);
    return remainder;
}

#if defined(__PCLMUL__) && defined(__SSE4_1__)

constexpr std::size_t lane = 16; ///< bytes of a vector
constexpr std::size_t stripe = 4 * lane;

__m128i load(std::span<const std::byte> bytes, std::size_t offset) {
    return _mm_loadu_si128(reinterpret_cast<const __m128i*>(bytes.data() + offset));
}

/// Moves the polynomial in `x` on by the distance that `constants` stand for and adds `next`.
__m128i fold(__m128i x, __m128i constants, __m128i next) {
    const __m128i low = _mm_clmulepi64_si128(x, constants, 0x00);
    const __m128i high = _mm_clmulepi64_si128(x, constants, 0x11);
    return _mm_xor_si128(_mm_xor_si128(low, high), next);
}

/// 128 bits to the remainder: two foldings and Barrett's reduction.
std::uint32_t reduce(__m128i x, __m128i by_one_lane) {
    const __m128i low_words = _mm_setr_epi32(~0, 0, ~0, 0);
    x = _mm_xor_si128(_mm_srli_si128(x, 8), _mm_clmulepi64_si128(x, by_one_lane, 0x10));
    const __m128i by_64_bits = _mm_set_epi64x(0, 0x163CD6124);
    x = _mm_xor_si128(_mm_srli_si128(x, 4),
                      _mm_clmulepi64_si128(_mm_and_si128(x, low_words), by_64_bits, 0x00));
    const __m128i polynomial_and_inverse = _mm_set_epi64x(0x1F7011641, 0x1DB710641);
    __m128i quotient =
        _mm_clmulepi64_si128(_mm_and_si128(x, low_words), polynomial_and_inverse, 0x10);
    quotient = _mm_clmulepi64_si128(_mm_and_si128(quotient, low_words), polynomial_and_inverse, 0);
    return static_cast<std::uint32_t>(_mm_extract_epi32(_mm_xor_si128(x, quotient), 1));
}

/// Multiplication without carry, four vectors side by side (Gopal et al. 2009, "Fast CRC
/// computation for generic polynomials using PCLMULQDQ", with its constants for this polynomial).
/// At least one stripe; takes whole vectors off the front of `bytes`.
std::uint32_t update_by_folding(std::uint32_t remainder, std::span<const std::byte>& bytes) {
    const __m128i by_four_lanes = _mm_set_epi64x(0x1C6E41596, 0x154442BD4);
    const __m128i by_one_lane = _mm_set_epi64x(0x0CCAA009E, 0x1751997D0);
    __m128i x[] = {load(bytes, 0), load(bytes, lane), load(bytes, 2 * lane), load(bytes, 3 * lane)};
    x[0] = _mm_xor_si128(x[0], _mm_cvtsi32_si128(static_cast<int>(remainder)));
    for (bytes = bytes.subspan(stripe); bytes.size() >= stripe; bytes = bytes.subspan(stripe))
        for (std::size_t k = 0; k < 4; ++k)
            x[k] = fold(x[k], by_four_lanes, load(bytes, k * lane));
    __m128i sum = x[0];
    for (std::size_t k = 1; k < 4; ++k)
        sum = fold(sum, by_one_lane, x[k]);
    for (; bytes.size() >= lane; bytes = bytes.subspan(lane))
        sum = fold(sum, by_one_lane, load(bytes, 0));
    return reduce(sum, by_one_lane);
}

#endif

} // namespace

std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t before) {
    std::uint32_t remainder = ~before;
#if defined(__PCLMUL__) && defined(__SSE4_1__)
    if (bytes.size() >= stripe)
        remainder = update_by_folding(remainder, bytes);
#endif
    return ~update_by_tables(remainder, bytes);
}

std::uint32_t crc32(std::string_view text) {
    return crc32(std::as_bytes(std::span(text.data(), text.size())));
}

} // namespace culm::archive
