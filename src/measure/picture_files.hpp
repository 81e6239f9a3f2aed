// SPDX-License-Identifier: BSD-3-Clause
// Frames from image sequences and video files, by OpenCV.
#pragma once

#include "measure/frame_source.hpp"

namespace culm::measure {

/// A numbered image sequence; `pattern` is a path whose file name contains one %d or %0Nd.
[[nodiscard]] std::unique_ptr<FrameSource>
open_image_sequence(const std::filesystem::path& pattern);

/// Any video file that OpenCV reads.
[[nodiscard]] std::unique_ptr<FrameSource> open_video_file(const std::filesystem::path& file);

} // namespace culm::measure
