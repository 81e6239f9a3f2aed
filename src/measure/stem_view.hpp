// SPDX-License-Identifier: BSD-3-Clause
// Chooses the way of looking at frames in which a stem stands out best.
#pragma once

#include "measure/stem_survey.hpp"

#include <vector>

namespace culm::measure {

/// Expected width of the stem in the picture, pixels: its depth over the scale, at least 2.
[[nodiscard]] double expected_stem_width(const TrackSettings& settings);

/// Threshold of a first trace: five times the noise, the same in all rows.
[[nodiscard]] TraceOptions first_trace_options(const BandImage& contrast, double noise,
                                               double stem_width);

/// Tries every orientation, band and sign that the settings leave open on these frames; the view
/// with the longest and clearest chains wins. Throws core::InputError if none shows a stem.
[[nodiscard]] StemView choose_view(const std::vector<FrameImage>& frames,
                                   const TrackSettings& settings, const std::string& source);

} // namespace culm::measure
