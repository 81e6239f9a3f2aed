// SPDX-License-Identifier: BSD-3-Clause
#include "measure/track/frames/frame_image.hpp"

#include <algorithm>

namespace culm::measure {

BandImage upright_band(const FrameImage& frame, Band band, Up up) {
    const int plane = frame.bands == 1 ? 0 : static_cast<int>(band);
    if (!is_sideways(up)) {
        BandImage image(frame.width, frame.height);
        for (int r = 0; r < frame.height; ++r) {
            const int source = up == Up::DecreasingRow ? r : frame.height - 1 - r;
            std::copy_n(frame.row(plane, source), frame.width, image.row(r));
        }
        return image;
    }
    BandImage image(frame.height, frame.width);
    for (int r = 0; r < frame.height; ++r) {
        const float* source = frame.row(plane, r);
        for (int c = 0; c < frame.width; ++c) {
            const int target = up == Up::DecreasingColumn ? c : frame.width - 1 - c;
            image.row(target)[r] = source[c];
        }
    }
    return image;
}

namespace {

PixelPoint transposed(PixelPoint point, Up up) {
    return is_sideways(up) ? PixelPoint{point.row, point.column} : point;
}

/// Reverses the direction along the stem in the frame if its tip is at larger rows or columns.
PixelPoint reversed(PixelPoint frame, int frame_width, int frame_height, Up up) {
    if (up == Up::IncreasingRow)
        frame.row = frame_height - 1 - frame.row;
    if (up == Up::IncreasingColumn)
        frame.column = frame_width - 1 - frame.column;
    return frame;
}

} // namespace

PixelPoint in_frame(PixelPoint upright, int frame_width, int frame_height, Up up) {
    return reversed(transposed(upright, up), frame_width, frame_height, up);
}

PixelPoint in_upright(PixelPoint frame, int frame_width, int frame_height, Up up) {
    return transposed(reversed(frame, frame_width, frame_height, up), up);
}

} // namespace culm::measure
