// SPDX-License-Identifier: BSD-3-Clause
// From a recording to a measurement: the paper's laboratory half.
#pragma once

#include "measure/measurement.hpp"
#include "measure/ring_down_window.hpp"
#include "measure/row_record.hpp"
#include "measure/stem_survey.hpp"
#include "measure/track_settings.hpp"

#include <string>
#include <vector>

namespace culm::measure {

struct TrackOptions {
    int threads = 1; ///< that share the frames
};

/// A measurement and how it came about.
struct Track {
    Measurement measurement;
    TrackSettings settings;
    std::string source;
    double frames_per_second = 0.0;
    StemSurvey survey;
    AxisRecord rows;    ///< every row of the upright picture, every frame
    AxisRecord heights; ///< at the measurement's heights, in pixels above the clamp
    RingDownWindow window;
    std::size_t first_kept = 0; ///< index of the first frame in the measurement
    std::size_t last_kept = 0;
    std::vector<std::string> remarks; ///< what a person should know, one sentence each
};

/// Tracks what video.toml describes. The result does not depend on the number of threads. Throws
/// core::InputError with what is wrong if the recording gives no trustworthy measurement.
[[nodiscard]] Track track_video(const TrackSettings& settings, const TrackOptions& options = {});

} // namespace culm::measure
