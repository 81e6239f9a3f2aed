// SPDX-License-Identifier: BSD-3-Clause
// Bright things that never move: reflections, marks on the background, the far wall.
#pragma once

#include "measure/stem_trace.hpp"

#include <cstdint>
#include <vector>

namespace culm::measure {

/// Pixels that stand out in every one of these contrast pictures and are not the stem, grown by one
/// pixel; (height, width), 1 = clutter. The still part of the stem above its clamp stands out in
/// every picture too: it is told apart as what continues the part that moves. Empty if too little
/// moves to tell.
[[nodiscard]] std::vector<std::uint8_t> find_still_clutter(const std::vector<BandImage>& contrasts,
                                                           const TraceOptions& options);

} // namespace culm::measure
