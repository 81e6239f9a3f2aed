// SPDX-License-Identifier: BSD-3-Clause
// What stands out from the background: the stem, and clutter that never moves.
#pragma once

#include "measure/track/frames/frame_image.hpp"
#include "measure/track/stem_trace.hpp"

#include <cstdint>
#include <vector>

namespace culm::measure {

/// `sign` times (grey value − background), where the background of a pixel is the median of its row
/// in a window of eight stem widths: a thin upright stem stands out, slow changes of the light and
/// wide bodies do not. `sign` is +1 for a stem brighter than its background, −1 for a darker one;
/// `stem_width` in pixels.
[[nodiscard]] BandImage stem_contrast(const BandImage& image, int sign, double stem_width);

/// Standard deviation of a contrast picture's background, grey values: that of the smallest nine
/// tenths of the absolute values, corrected for the cut; at least 0.25, which 8 bits cannot resolve
/// below.
[[nodiscard]] double contrast_noise(const BandImage& contrast);

/// Pixels that stand out in every one of these contrast pictures and are not the stem, grown by one
/// pixel; (height, width), 1 = clutter. The still part of the stem above its clamp stands out in
/// every picture too: it is recognised as what continues the part that moves. Empty if too little
/// moves.
[[nodiscard]] std::vector<std::uint8_t> find_still_clutter(const std::vector<BandImage>& contrasts,
                                                           const TraceOptions& options);

} // namespace culm::measure
