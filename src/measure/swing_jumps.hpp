// SPDX-License-Identifier: BSD-3-Clause
// Frames that were lost without a gap in their numbers, by the jumps of the swing.
#pragma once

#include "measure/release_moment.hpp"
#include "measure/swing_model.hpp"

#include <string>
#include <vector>

namespace culm::measure {

/// What the jumps are judged by.
struct SwingOfPlace {
    double rest = 0.0;             ///< column
    double relative_height = 1.0;  ///< of the place, of the stem's length
    double decay_per_cycle = 0.0;  ///< 2πζ
    std::size_t settled_frame = 0; ///< index from which on the first mode swings alone
};

/// Remarks about frames before which some were lost or doubled. While higher modes still sound, by
/// the times between the first passages through the rest, which they hardly move: 4 % of a period
/// is a jump. Afterwards by what the recurrence `model` (lag 1) leaves: an eighth of the amplitude.
[[nodiscard]] std::vector<std::string> find_jumps(const WatchedHistory& history,
                                                  const ReleaseMoment& release,
                                                  const SwingModel& model,
                                                  const SwingOfPlace& swing);

} // namespace culm::measure
