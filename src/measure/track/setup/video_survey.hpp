// SPDX-License-Identifier: BSD-3-Clause
// A first look at a recording without scale and specimen: where the stem is and when it is
// released.
#pragma once

#include "measure/track/track.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace culm::measure {

/// The stem as found in the pictures; points are those of the frames as recorded, in pixels.
struct DetectedStem {
    StemView view;
    PixelPoint clamp;
    PixelPoint tip; ///< at rest
    double width = 0.0;
    std::optional<int> release_frame; ///< the last one in which it is held
    std::string pull_side;            ///< "left", "right", "top", "bottom"; empty: unknown
    double pull = 0.0;                ///< at the highest place that is always seen
    double cycles_per_frame = 0.0;    ///< of the swing; 0: unknown
};

/// One frame that shows how the stem moves.
struct ShownFrame {
    std::size_t index = 0; ///< in the source
    int number = 0;
    std::string caption;
    std::vector<PixelPoint> axis; ///< of the stem; empty where it was not seen
};

struct VideoSurvey {
    int width = 0; ///< of the frames, pixels
    int height = 0;
    int bands = 1;
    std::optional<DetectedStem> stem; ///< empty: none was found
    std::string remark;               ///< why something was not found; empty if all was
    std::vector<ShownFrame> frames;   ///< ascending
};

/// Finds the stem with the tracker's own survey and first pass. The stem's width, which the tracker
/// computes from the scale, is the one of some widths at which the stem is clearest. In a
/// long recording only the part about the release is searched: as many frames as are read in some
/// tens of seconds. Throws core::InputError if frames cannot be read.
[[nodiscard]] VideoSurvey survey_video(const FrameSource& source, int threads);

/// For the page of `culm setup` (postprocess/setup.py): what was found, the frames as JPEG of at
/// most 900 pixels, the allowed numbers of video.toml, and the thresholds of the tracker's checks.
/// Throws core::InputError if frames cannot be read.
[[nodiscard]] nlohmann::ordered_json to_json(const FrameSource& source, const VideoSurvey& survey);

} // namespace culm::measure
