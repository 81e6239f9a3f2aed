// SPDX-License-Identifier: BSD-3-Clause
// Recordings of Photron cameras: a header (.cih, .cihx) and raw pixels (.mraw).
#pragma once

#include "measure/frame_source.hpp"

#include <cstddef>
#include <cstdint>
#include <span>

namespace culm::measure {

/// What the header says of the pixels and of time.
struct PhotronHeader {
    int width = 0;
    int height = 0;
    int frames = 0;
    int bits_per_pixel = 0;      ///< as stored: 8, 10, 12 or 16
    int effective_bits = 0;      ///< that the camera digitised; 0 if the header does not say
    bool is_high_aligned = true; ///< effective bits fill the stored pixel from the top
    double record_rate = 0.0;    ///< frames/s of the camera
    int save_step = 1;           ///< one in so many recorded frames was saved

    [[nodiscard]] std::size_t bytes_per_frame() const;
    [[nodiscard]] double frames_per_second() const { return record_rate / save_step; }
};

/// Reads a header. Throws core::InputError naming the entry that is missing or not supported
/// (colour, other file formats than MRaw).
[[nodiscard]] PhotronHeader read_photron_header(const std::filesystem::path& file);

/// Grey values of one frame on a scale to 255. 10 and 12 bits are packed without gaps, the highest
/// bit first; 16 bits have the low byte first. `bytes` holds bytes_per_frame().
[[nodiscard]] FrameImage unpack_photron(const PhotronHeader& header,
                                        std::span<const std::uint8_t> bytes);

/// `header` is a .cih or .cihx file; the .mraw with the same name must lie beside it. Throws
/// core::InputError, also if the raw file is shorter than the header promises.
[[nodiscard]] std::unique_ptr<FrameSource> open_photron(const std::filesystem::path& header);

} // namespace culm::measure
