// SPDX-License-Identifier: BSD-3-Clause
// One frame of a recording as plain numbers, and the possible orientations of a stem in it.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace culm::measure {

/// Bands of a frame. A grey frame has only `Red`, which contains the grey values.
enum class Band { Red = 0, Green = 1, Blue = 2 };
/// The names in video.toml.
inline constexpr std::array band_names{"red", "green", "blue"};
[[nodiscard]] inline const char* to_string(Band band) {
    return band_names.at(static_cast<std::size_t>(band));
}

/// Grey values of one or three bands on a scale where the format's largest value is 255.
struct FrameImage {
    int width = 0;
    int height = 0;
    int bands = 1;             ///< 1 (grey) or 3 (red, green, blue)
    std::vector<float> values; ///< (bands, height, width) row-major

    [[nodiscard]] const float* row(int band, int r) const {
        return values.data() +
               (std::size_t(band) * std::size_t(height) + std::size_t(r)) * std::size_t(width);
    }
};

/// One band, turned so that the stem is upright: its tip is in a row above its clamp.
struct BandImage {
    int width = 0;
    int height = 0;
    std::vector<float> values; ///< (height, width) row-major

    BandImage() = default;
    BandImage(int columns, int rows, float value = 0.0F)
        : width(columns), height(rows), values(std::size_t(columns) * std::size_t(rows), value) {}
    [[nodiscard]] float* row(int r) { return values.data() + std::size_t(r) * std::size_t(width); }
    [[nodiscard]] const float* row(int r) const {
        return values.data() + std::size_t(r) * std::size_t(width);
    }
};

/// Direction in the picture from the clamp to the tip.
enum class Up { DecreasingRow, IncreasingRow, DecreasingColumn, IncreasingColumn };
/// The names in video.toml.
inline constexpr std::array up_names{"decreasing_row", "increasing_row", "decreasing_column",
                                     "increasing_column"};
[[nodiscard]] inline const char* to_string(Up up) {
    return up_names.at(static_cast<std::size_t>(up));
}

/// Is the stem horizontal in the picture?
[[nodiscard]] inline bool is_sideways(Up up) {
    return up == Up::DecreasingColumn || up == Up::IncreasingColumn;
}

/// The band of a frame as an upright picture. For a sideways stem the picture is transposed: the
/// columns of the upright picture are the rows of the frame.
[[nodiscard]] BandImage upright_band(const FrameImage& frame, Band band, Up up);

/// A point of the upright picture of a frame (column, row) as a point of the frame.
struct PixelPoint {
    double column = 0.0;
    double row = 0.0;
};
[[nodiscard]] PixelPoint in_frame(PixelPoint upright, int frame_width, int frame_height, Up up);
/// The inverse of in_frame().
[[nodiscard]] PixelPoint in_upright(PixelPoint frame, int frame_width, int frame_height, Up up);

} // namespace culm::measure
