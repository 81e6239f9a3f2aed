// SPDX-License-Identifier: BSD-3-Clause
#include "measure/track/frames/frame_from_opencv.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <array>

#include <fmt/core.h>

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

FrameImage frame_from(const cv::Mat& picture, const std::string& name) {
    // Scales to the range of 8 bits, the unit of every threshold of the tracker.
    double scale = 1.0;
    switch (picture.depth()) {
    case CV_8U:
        break;
    case CV_16U:
        scale = 255.0 / 65535.0;
        break;
    case CV_32F:
    case CV_64F:
        scale = 255.0;
        break;
    default:
        throw core::InputError(fmt::format("{}: pixels must have 8 or 16 bits", name));
    }
    cv::Mat scaled;
    picture.convertTo(scaled, CV_32F, scale);
    const int channels = scaled.channels();
    if (channels < 1 || channels > 4)
        throw core::InputError(fmt::format("{}: {} channels; must be 1 to 4", name, channels));

    FrameImage frame;
    frame.width = scaled.cols;
    frame.height = scaled.rows;
    frame.bands = channels <= 2 ? 1 : 3;
    const std::size_t area = std::size_t(frame.width) * std::size_t(frame.height);
    frame.values.resize(area * std::size_t(frame.bands));
    for (int band = 0; band < frame.bands; ++band) {
        cv::Mat plane(frame.height, frame.width, CV_32F,
                      frame.values.data() + std::size_t(band) * area);
        // OpenCV orders colours blue, green, red.
        cv::extractChannel(scaled, plane, frame.bands == 1 ? 0 : 2 - band);
    }
    return frame;
}

cv::Mat picture_from(const FrameImage& frame) {
    cv::Mat picture(frame.height, frame.width, CV_8UC3);
    for (int r = 0; r < frame.height; ++r) {
        std::array<const float*, 3> rows{};
        for (int band = 0; band < 3; ++band)
            rows.at(std::size_t(band)) = frame.row(frame.bands == 1 ? 0 : band, r);
        for (int c = 0; c < frame.width; ++c)
            picture.at<cv::Vec3b>(r, c) = {cv::saturate_cast<uchar>(rows[2][c]),
                                           cv::saturate_cast<uchar>(rows[1][c]),
                                           cv::saturate_cast<uchar>(rows[0][c])};
    }
    return picture;
}

} // namespace culm::measure
