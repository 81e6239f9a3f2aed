// SPDX-License-Identifier: BSD-3-Clause
// Contrast to the background: the stem, and clutter that never moves.
#pragma once

#include "measure/track/frames/frame_image.hpp"
#include "measure/track/stem_trace.hpp"

#include <cstdint>
#include <vector>

namespace culm::measure {

/// `sign` times (grey value − background), where the background of a pixel is the median of its row
/// in a window of eight stem widths. A thin upright stem has a high contrast; slow changes of the
/// light and wide bodies do not. `sign` is +1 for a stem brighter than its background, −1 for a
/// darker one; `stem_width` in pixels.
[[nodiscard]] BandImage stem_contrast(const BandImage& image, int sign, double stem_width);

/// Standard deviation of a contrast picture's background, grey values: that of the smallest nine
/// tenths of the absolute values, corrected for the cut, and at least 0.25, the resolution of 8
/// bits.
[[nodiscard]] double contrast_noise(const BandImage& contrast);

/// Pixels with a high contrast in all of these pictures that are not the stem, grown by one pixel;
/// (height, width), 1 = clutter. The still part of the stem above its clamp has a high contrast in
/// all pictures too; it is recognised because the moving part continues it. Empty if too little
/// moves.
[[nodiscard]] std::vector<std::uint8_t> find_still_clutter(const std::vector<BandImage>& contrasts,
                                                           const TraceOptions& options);

} // namespace culm::measure
