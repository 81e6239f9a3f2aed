// SPDX-License-Identifier: BSD-3-Clause
#include "measure/track/frames/frame_from_opencv.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <array>

#include <fmt/core.h>

namespace culm::measure {

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
    std::vector<cv::Mat> planes;
    cv::split(scaled, planes);
    const std::size_t area = std::size_t(frame.width) * std::size_t(frame.height);
    frame.values.resize(area * std::size_t(frame.bands));
    for (int band = 0; band < frame.bands; ++band) {
        // OpenCV orders colours blue, green, red.
        const cv::Mat& plane = planes[frame.bands == 1 ? 0U : std::size_t(2 - band)];
        for (int r = 0; r < frame.height; ++r)
            std::copy_n(plane.ptr<float>(r), frame.width,
                        frame.values.begin() +
                            std::ptrdiff_t(std::size_t(band) * area +
                                           std::size_t(r) * std::size_t(frame.width)));
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
