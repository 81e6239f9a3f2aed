// SPDX-License-Identifier: BSD-3-Clause
#include "measure/track/frames/frame_from_opencv.hpp"

#include "core/error.hpp"

#include <vector>

#include <fmt/core.h>

namespace culm::measure {

namespace {

/// A band as a matrix that shares the frame's pixels.
cv::Mat plane_of(const FrameImage& frame, int band) {
    // OpenCV has no matrix of constant pixels.
    return {frame.height, frame.width, CV_32F, const_cast<float*>(frame.row(band, 0))};
}

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

BandImage upright_band(const FrameImage& frame, Band band, Up up) {
    const cv::Mat plane = plane_of(frame, frame.bands == 1 ? 0 : static_cast<int>(band));
    BandImage image = is_sideways(up) ? BandImage(frame.height, frame.width)
                                      : BandImage(frame.width, frame.height);
    cv::Mat upright(image.height, image.width, CV_32F, image.values.data());
    if (is_sideways(up))
        cv::transpose(plane, upright);
    else
        plane.copyTo(upright);
    if (up == Up::IncreasingRow || up == Up::IncreasingColumn)
        cv::flip(upright, upright, 0);
    return image;
}

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
    frame.values.resize(scaled.total() * std::size_t(frame.bands));
    for (int band = 0; band < frame.bands; ++band) {
        cv::Mat plane = plane_of(frame, band);
        // OpenCV orders colours blue, green, red.
        cv::extractChannel(scaled, plane, frame.bands == 1 ? 0 : 2 - band);
    }
    return frame;
}

cv::Mat picture_from(const FrameImage& frame) {
    std::vector<cv::Mat> planes;
    for (const int band : {2, 1, 0}) // OpenCV orders colours blue, green, red
        planes.push_back(plane_of(frame, frame.bands == 1 ? 0 : band));
    cv::Mat picture;
    cv::merge(planes, picture);
    picture.convertTo(picture, CV_8U);
    return picture;
}

} // namespace culm::measure
