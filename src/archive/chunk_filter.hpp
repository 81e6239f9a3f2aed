// SPDX-License-Identifier: BSD-3-Clause
// One chunk of doubles as HDF5's filters shuffle, deflate and fletcher32 would store it, but in a
// fraction of their time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace culm::archive {

/// HDF5's Fletcher checksum of these bytes, as its filter appends it (least significant byte
/// first).
[[nodiscard]] std::uint32_t fletcher32(std::span<const std::byte> bytes);

/// Makes chunks for H5Dwrite_chunk. Of a shuffled double the low bytes are as good as random: they
/// go into the deflate stream as they are (stored blocks), and only planes of bytes that show
/// structure are compressed. Any reader sees an ordinary zlib stream. The same values give the same
/// bytes.
class ChunkFilter {
  public:
    /// `compression`: deflate level behind the shuffle filter, 1 … 9; 0: only the checksum.
    /// StorageError if zlib has no memory.
    explicit ChunkFilter(int compression);
    ~ChunkFilter();
    ChunkFilter(const ChunkFilter&) = delete;
    ChunkFilter& operator=(const ChunkFilter&) = delete;

    /// The bytes to be stored; valid until the next call. StorageError if zlib fails.
    [[nodiscard]] std::span<const std::byte> apply(std::span<const double> values);

  private:
    struct Deflater;

    void shuffle(std::span<const double> values);

    std::unique_ptr<Deflater> deflater_; ///< none without compression
    std::vector<std::byte> shuffled_;    ///< (8, values): planes of bytes
    std::vector<std::byte> stored_;
};

} // namespace culm::archive
