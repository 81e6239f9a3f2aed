// SPDX-License-Identifier: BSD-3-Clause
// A foreign recording as a measurement.
#pragma once

#include "measure/folder/measurement.hpp"
#include "measure/import/import_mapping.hpp"

#include <cstddef>
#include <span>

namespace culm::measure {

/// Reads the mapping's source and makes a measurement of it: the mean over the columns or markers
/// of each height, less the motion of the clamp's, from the zero that the mapping chooses, with t =
/// 0 at the release. A release to be detected lies where the mean deflection leaves the level of
/// the first frames for good; between two frames by the square root of the travel, which grows
/// linearly in time under a sudden force. Where the mapping gives no noise it is the scatter about
/// the mean before the release (at least 8 frames), and noise_source says so; frames in which
/// the stem moves tell no noise, and a remark says that. Throws core::InputError.
[[nodiscard]] Measurement import_recording(const ImportMapping& mapping);

/// Where consecutive frames lie further apart than one and a half usual frames.
struct TimeGaps {
    std::size_t count = 0;
    double longest = 0.0;          ///< s, from frame to frame
    double begin_of_longest = 0.0; ///< s
};
[[nodiscard]] TimeGaps time_gaps(std::span<const double> times);

} // namespace culm::measure
