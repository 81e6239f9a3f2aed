// SPDX-License-Identifier: BSD-3-Clause
#include "archive/chunk_filter.hpp"

#include "archive/little_endian.hpp"
#include "core/error.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <string>

#include <fmt/format.h>
#include <zlib.h>

namespace culm::archive {

namespace {

constexpr std::size_t width = sizeof(double);
constexpr std::size_t checksum_size = sizeof(std::uint32_t);

/// Ones' complement: what does not fit into 16 bits is added in at the bottom.
std::uint32_t folded(std::uint64_t sum) {
    while (sum > 0xFFFFU)
        sum = (sum & 0xFFFFU) + (sum >> 16U);
    return static_cast<std::uint32_t>(sum);
}

/// Whether compression would save something: among bytes that are as good as random, two of n are
/// equal with a probability of 1/256.
bool has_structure(std::span<const std::byte> plane) {
    constexpr std::size_t most_samples = 2048;
    const std::size_t stride = std::max<std::size_t>(1, plane.size() / most_samples);
    std::array<std::uint32_t, 256> count{};
    std::size_t samples = 0;
    for (std::size_t i = 0; i < plane.size(); i += stride, ++samples)
        ++count[std::to_integer<std::size_t>(plane[i])];
    double pairs = 0.0;
    for (const std::uint32_t n : count)
        pairs += static_cast<double>(n) * (static_cast<double>(n) - 1.0);
    const auto all = static_cast<double>(samples);
    return 256.0 * pairs > 1.5 * all * (all - 1.0);
}

} // namespace

std::uint32_t fletcher32(std::span<const std::byte> bytes) {
    // As in HDF5: words of two bytes, the first one being the higher; sums modulo 65535. Within a
    // block the second sum is the first one times the block's length plus each word times how often
    // it is counted: sums that a compiler can vectorise and 32 bits can hold.
    constexpr std::size_t block = 256;
    std::uint64_t sum = 0;
    std::uint64_t sum_of_sums = 0;
    std::array<std::uint16_t, block> words{};
    while (!bytes.empty()) {
        const std::size_t size = std::min(bytes.size(), 2 * block);
        const std::size_t count = (size + 1) / 2;
        words[count - 1] = 0;
        std::memcpy(words.data(), bytes.data(), size);
        bytes = bytes.subspan(size);
        std::uint32_t plain = 0;
        std::uint32_t weighted = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const std::uint32_t stored = words[i];
            const std::uint32_t word = std::endian::native == std::endian::little
                                           ? ((stored & 0xFFU) << 8U) | (stored >> 8U)
                                           : stored;
            plain += word;
            weighted += static_cast<std::uint32_t>(count - i) * word;
        }
        sum_of_sums = folded(sum_of_sums + count * sum + weighted);
        sum = folded(sum + plain);
    }
    return (static_cast<std::uint32_t>(sum_of_sums) << 16U) | static_cast<std::uint32_t>(sum);
}

/// A zlib stream that is used again and again: setting one up costs as much as some 10 kB of work.
struct ChunkFilter::Deflater {
    explicit Deflater(int compression) : level(compression) {
        check(deflateInit(&stream, level), "start");
    }
    ~Deflater() { deflateEnd(&stream); }
    Deflater(const Deflater&) = delete;
    Deflater& operator=(const Deflater&) = delete;

    /// Compresses planes into `out`, which is resized to what zlib made.
    void compress(const std::vector<std::byte>& planes, std::vector<std::byte>& out) {
        const std::size_t plane_size = planes.size() / width;
        check(deflateReset(&stream), "start");
        // Room for stored blocks, and for the end of a block at every change of the level.
        out.resize(deflateBound(&stream, static_cast<uLong>(planes.size())) + 1024);
        stream.next_out = reinterpret_cast<Bytef*>(out.data());
        stream.avail_out = static_cast<uInt>(out.size());
        for (std::size_t k = 0; k < width; ++k) {
            const auto plane = std::span(planes).subspan(k * plane_size, plane_size);
            const int wanted = has_structure(plane) ? level : Z_NO_COMPRESSION;
            check(deflateParams(&stream, wanted, Z_DEFAULT_STRATEGY), "change the level");
            stream.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(plane.data()));
            stream.avail_in = static_cast<uInt>(plane.size());
            check(deflate(&stream, k + 1 < width ? Z_NO_FLUSH : Z_FINISH), "compress");
        }
        out.resize(stream.total_out);
    }

  private:
    static void check(int code, const char* action) {
        if (code != Z_OK && code != Z_STREAM_END)
            throw core::StorageError(fmt::format("zlib cannot {}: {}", action, zError(code)));
    }

    z_stream stream{};
    int level;
};

ChunkFilter::ChunkFilter(int compression)
    : deflater_(compression > 0 ? std::make_unique<Deflater>(compression) : nullptr) {}

ChunkFilter::~ChunkFilter() = default;

std::span<const std::byte> ChunkFilter::apply(std::span<const double> values) {
    if (deflater_) {
        shuffle(values);
        deflater_->compress(shuffled_, stored_);
    } else {
        ByteWriter writer(std::move(stored_));
        writer.clear();
        writer.put_values(values);
        stored_ = writer.take();
    }
    const std::uint32_t checksum = fletcher32(stored_);
    for (std::size_t k = 0; k < checksum_size; ++k)
        stored_.push_back(static_cast<std::byte>(checksum >> (8 * k)));
    return stored_;
}

void ChunkFilter::shuffle(std::span<const double> values) {
    const std::size_t count = values.size();
    shuffled_.resize(width * count);
    for (std::size_t byte = 0; byte < width; ++byte)
        for (std::size_t i = 0; i < count; ++i)
            shuffled_[byte * count + i] =
                static_cast<std::byte>(std::bit_cast<std::uint64_t>(values[i]) >> (8 * byte));
}

} // namespace culm::archive
