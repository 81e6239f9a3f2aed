// SPDX-License-Identifier: BSD-3-Clause
// A first look at some frames: how the stem stands, what it looks like, and what is not the stem.
#pragma once

#include "measure/frame_source.hpp"
#include "measure/stem_trace.hpp"
#include "measure/track_settings.hpp"

#include <span>
#include <string>
#include <vector>

namespace culm::measure {

/// How to look at a frame so that the stem stands out, upright.
struct StemView {
    Up up = Up::DecreasingRow;
    Band band = Band::Red;
    int sign = 1; ///< +1: brighter than its background, −1: darker

    friend bool operator==(const StemView&, const StemView&) = default;
};

/// What tracking a frame needs to know; rows and columns are those of the upright picture.
struct StemSurvey {
    StemView view;
    int frame_width = 0; ///< pixels, as recorded
    int frame_height = 0;
    int bands = 1;
    TraceOptions trace;
    double clamp_row = 0.0; ///< where the height is 0
    bool clamp_is_detected = false;
    bool up_is_detected = false;
    double noise = 0.0;    ///< of the contrast, grey values
    double contrast = 0.0; ///< of the stem against its background, median over rows, grey values
    double apparent_width = 0.0; ///< of the stem, pixels
    std::vector<std::string> remarks;
};

/// Looks at up to 40 of the `wanted` frames. What the settings leave open is found: the way the
/// stem stands (the end that moves least is clamped), the band and the sign with the clearest stem,
/// clutter (pixels that stand out in all frames and do not continue the part that moves), the
/// threshold (in every row half the stem's contrast there: a histogram's valley, as Otsu's, is none
/// where the stem covers two per cent of the pixels) and the clamp's row. Throws core::InputError
/// if no stem is found.
[[nodiscard]] StemSurvey survey_stem(const FrameSource& source, std::span<const std::size_t> wanted,
                                     const TrackSettings& settings, int threads);

} // namespace culm::measure
