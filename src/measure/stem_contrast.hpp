// SPDX-License-Identifier: BSD-3-Clause
// How far each pixel stands out from its surroundings, so that uneven light does not matter.
#pragma once

#include "measure/frame_image.hpp"

namespace culm::measure {

/// `sign` times (grey value − background), where the background of a pixel is the median of its row
/// in a window of eight stem widths: a thin upright stem stands out, slow changes of the light and
/// wide bodies do not. `sign` is +1 for a stem brighter than its background, −1 for a darker one;
/// `stem_width` in pixels.
[[nodiscard]] BandImage stem_contrast(const BandImage& image, int sign, double stem_width);

/// Standard deviation of a contrast picture's background, grey values: that of the smallest nine
/// tenths of the absolute values, corrected for the cut; at least 0.25, below which 8 bits tell
/// nothing.
[[nodiscard]] double contrast_noise(const BandImage& contrast);

} // namespace culm::measure
