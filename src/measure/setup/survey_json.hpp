// SPDX-License-Identifier: BSD-3-Clause
// The survey of a recording for the page of `culm setup` (postprocess/setup.py).
#pragma once

#include "measure/setup/video_survey.hpp"

#include <nlohmann/json.hpp>

namespace culm::measure {

/// What was found, the frames as JPEG of at most 900 pixels, the allowed numbers of video.toml, and
/// the thresholds of the tracker's checks. Throws core::InputError if frames cannot be read.
[[nodiscard]] nlohmann::ordered_json to_json(const FrameSource& source, const VideoSurvey& survey);

} // namespace culm::measure
