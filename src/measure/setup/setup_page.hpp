// SPDX-License-Identifier: BSD-3-Clause
// The page of `culm setup`: the frames of a recording and what was found in them, for a person who
// corrects it and saves video.toml.
#pragma once

#include "measure/setup/video_survey.hpp"

#include <filesystem>
#include <string>

namespace culm::measure {

/// A recording that is being set up.
struct SetupRecording {
    std::filesystem::path folder; ///< of video.toml, as the user named it
    std::string frames;           ///< value of video.frames, relative to the folder
    std::string program;          ///< name and version
    std::string next_command;     ///< that tracks the recording
};

/// One HTML file without references to others: frames as JPEG of at most 900 pixels, and JSON with
/// the survey, the allowed numbers of video.toml and the thresholds of the tracker's checks. Throws
/// core::InputError if frames cannot be read.
[[nodiscard]] std::string setup_page(const SetupRecording& recording, const FrameSource& source,
                                     const VideoSurvey& survey);

} // namespace culm::measure
