// SPDX-License-Identifier: BSD-3-Clause
#include "measure/track/frames/frame_image.hpp"

#include <algorithm>

namespace culm::measure {

BandImage upright_band(const FrameImage& frame, Band band, Up up) {
    const int plane = frame.bands == 1 ? 0 : static_cast<int>(band);
    if (up == Up::DecreasingRow || up == Up::IncreasingRow) {
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

PixelPoint in_frame(PixelPoint upright, int frame_width, int frame_height, Up up) {
    switch (up) {
    case Up::DecreasingRow:
        return upright;
    case Up::IncreasingRow:
        return {upright.column, frame_height - 1 - upright.row};
    case Up::DecreasingColumn:
        return {upright.row, upright.column};
    case Up::IncreasingColumn:
        break;
    }
    return {frame_width - 1 - upright.row, upright.column};
}

PixelPoint in_upright(PixelPoint frame, int frame_width, int frame_height, Up up) {
    switch (up) {
    case Up::DecreasingRow:
        return frame;
    case Up::IncreasingRow:
        return {frame.column, frame_height - 1 - frame.row};
    case Up::DecreasingColumn:
        return {frame.row, frame.column};
    case Up::IncreasingColumn:
        break;
    }
    return {frame.row, frame_width - 1 - frame.column};
}

} // namespace culm::measure
