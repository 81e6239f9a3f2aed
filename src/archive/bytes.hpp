// SPDX-License-Identifier: BSD-3-Clause
// Numbers, texts and arrays as little-endian bytes, and the checksum of bytes.
#pragma once

#include "core/error.hpp"

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <zlib.h>

namespace culm::archive {

static_assert(std::endian::native == std::endian::little, "doubles are written as they are");

/// Appends values to a growing block of bytes.
class ByteWriter {
  public:
    ByteWriter() = default;
    /// Appends to these bytes.
    explicit ByteWriter(std::vector<std::byte> bytes) : bytes_(std::move(bytes)) {}

    template <std::integral T>
    void put(T value) {
        for (std::size_t i = 0; i < sizeof(T); ++i)
            bytes_.push_back(static_cast<std::byte>(static_cast<std::uint64_t>(value) >> (8 * i)));
    }
    void put_bytes(std::span<const std::byte> bytes) {
        bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    }
    /// Length (u32) and the bytes of the text.
    void put_text(std::string_view text) {
        put(static_cast<std::uint32_t>(text.size()));
        put_bytes(std::as_bytes(std::span(text.data(), text.size())));
    }
    /// Count (u64) and the values (IEEE 754 binary64).
    void put_doubles(std::span<const double> values) {
        put(static_cast<std::uint64_t>(values.size()));
        put_bytes(std::as_bytes(values));
    }
    /// Reserves memory for `size` more bytes.
    void reserve(std::size_t size) { bytes_.reserve(bytes_.size() + size); }
    [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }
    [[nodiscard]] std::vector<std::byte> take() { return std::move(bytes_); }

  private:
    std::vector<std::byte> bytes_;
};

/// Reads values from the front of a block of bytes. Throws a StorageError that begins with `where`
/// if the block is shorter than the lengths in it require.
class ByteReader {
  public:
    ByteReader(std::span<const std::byte> bytes, std::string_view where)
        : bytes_(bytes), where_(where) {}

    template <std::integral T>
    [[nodiscard]] T get() {
        const std::span<const std::byte> raw = take(sizeof(T));
        std::uint64_t value = 0;
        for (std::size_t i = 0; i < sizeof(T); ++i)
            value |= std::to_integer<std::uint64_t>(raw[i]) << (8 * i);
        return static_cast<T>(value);
    }
    [[nodiscard]] std::string get_text() {
        const std::span<const std::byte> raw = take(get<std::uint32_t>());
        return {reinterpret_cast<const char*>(raw.data()), raw.size()};
    }
    [[nodiscard]] std::vector<double> get_doubles() {
        const auto count = get<std::uint64_t>();
        if (count > bytes_.size() / sizeof(double))
            throw_too_short();
        std::vector<double> values(count);
        const std::span<const std::byte> raw = take(count * sizeof(double));
        if (!raw.empty())
            std::memcpy(values.data(), raw.data(), raw.size());
        return values;
    }
    [[nodiscard]] std::span<const std::byte> take(std::size_t size) {
        if (size > bytes_.size())
            throw_too_short();
        const std::span<const std::byte> front = bytes_.first(size);
        bytes_ = bytes_.subspan(size);
        return front;
    }
    [[nodiscard]] bool is_empty() const { return bytes_.empty(); }

  private:
    [[noreturn]] void throw_too_short() const {
        throw core::StorageError(std::string(where_) +
                                 ": the content is shorter than its own lengths say");
    }

    std::span<const std::byte> bytes_;
    std::string_view where_;
};

/// CRC-32 of ISO 3309 (zip, Ethernet), continued from the CRC-32 of the preceding bytes.
[[nodiscard]] inline std::uint32_t crc32(std::span<const std::byte> bytes,
                                         std::uint32_t before = 0) {
    return static_cast<std::uint32_t>(
        ::crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

[[nodiscard]] inline std::uint32_t crc32(std::string_view text) {
    return crc32(std::as_bytes(std::span(text.data(), text.size())));
}

} // namespace culm::archive
