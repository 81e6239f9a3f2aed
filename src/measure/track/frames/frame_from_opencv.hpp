// SPDX-License-Identifier: BSD-3-Clause
// Conversion of OpenCV's pictures to plain numbers and back.
#pragma once

#include "measure/track/frames/frame_image.hpp"

#include <string>

#include <opencv2/core.hpp>

namespace culm::measure {

/// Scales so that the format's largest value becomes 255; drops transparency. Throws
/// core::InputError, beginning with `name`, unless the picture has 1 … 4 channels of 8 or 16 bits
/// or floating point (interpreted as 0 … 1).
[[nodiscard]] FrameImage frame_from(const cv::Mat& picture, const std::string& name);

/// An 8-bit blue-green-red picture for drawing on.
[[nodiscard]] cv::Mat picture_from(const FrameImage& frame);

} // namespace culm::measure
