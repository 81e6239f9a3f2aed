// SPDX-License-Identifier: BSD-3-Clause
// A first look at a recording without scale and specimen: where the stem is and when it is
// released.
#pragma once

#include "measure/track/track.hpp"

#include <nlohmann/json.hpp>

namespace culm::measure {

/// Finds the stem with the tracker's own survey and first pass. The stem's width, which the tracker
/// computes from the scale, is the one of some widths at which the stem is clearest. In a
/// long recording only the part about the release is searched: as many frames as are read in some
/// tens of seconds. The result is for the page of `culm setup` (postprocess/setup.py): what was
/// found, in pixels of the frames as recorded, some frames as JPEG of at most 900 pixels, the
/// allowed numbers of video.toml, and the thresholds of the tracker's checks. Throws
/// core::InputError if frames cannot be read.
[[nodiscard]] nlohmann::ordered_json survey_video(const FrameSource& source, int threads);

} // namespace culm::measure
