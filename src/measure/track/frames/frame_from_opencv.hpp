// SPDX-License-Identifier: BSD-3-Clause
// From OpenCV's pictures to plain numbers and back.
#pragma once

#include "measure/track/frames/frame_image.hpp"

#include <string>

#include <opencv2/core.hpp>

namespace culm::measure {

/// Scaled so that the format's largest value becomes 255; transparency is dropped. Throws
/// core::InputError, beginning with `name`, for numbers of channels or formats other than 1 … 4 and
/// 8 or 16 bits or floating point (taken as 0 … 1).
[[nodiscard]] FrameImage frame_from(const cv::Mat& picture, const std::string& name);

/// An 8-bit blue-green-red picture for drawing on.
[[nodiscard]] cv::Mat picture_from(const FrameImage& frame);

} // namespace culm::measure
