// SPDX-License-Identifier: BSD-3-Clause
// Setting up a recording in a terminal: `culm setup --text`.
#pragma once

#include "measure/setup/setup_page.hpp"

#include <functional>
#include <optional>
#include <string>

namespace culm::measure {

/// Shows a question and returns the answer, without blanks at its ends; nothing when the input has
/// ended.
using Ask = std::function<std::optional<std::string>(const std::string& question)>;

/// What was found, in a few lines.
[[nodiscard]] std::string survey_text(const FrameSource& source, const VideoSurvey& survey);

/// Asks for what the pictures do not show, and to confirm what they show; an empty answer takes the
/// value in brackets. An answer that video.toml does not allow is asked for again, with the reason
/// in the question. Returns the text of video.toml. Throws core::InputError if the answers end
/// early.
[[nodiscard]] std::string ask_for_settings(const Ask& ask, const SetupRecording& recording,
                                           const FrameSource& source, const VideoSurvey& survey);

} // namespace culm::measure
