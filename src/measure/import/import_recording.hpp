// SPDX-License-Identifier: BSD-3-Clause
// Converts a foreign recording to a measurement.
#pragma once

#include "measure/folder/measurement.hpp"
#include "measure/import/import_mapping.hpp"

#include <cstddef>
#include <span>

namespace culm::measure {

/// Reads the mapping's source and returns a measurement: the mean over the columns or markers of
/// each height, less the motion of the clamp's, relative to the zero that the mapping chooses, with
/// t = 0 at the release. A detected release is the time at which the mean deflection finally leaves
/// the level of the first frames, interpolated between two frames by the root of the travel, which
/// is linear in time under a sudden force. If the mapping states no noise, it is the scatter before
/// the release (at least 8 frames), reported in noise_source. Frames in which the stem moves are
/// not used for the noise; a remark reports them. Throws core::InputError.
[[nodiscard]] Measurement import_recording(const ImportMapping& mapping);

/// Gaps between consecutive frames that are longer than one and a half usual frame times.
struct TimeGaps {
    std::size_t count = 0;
    double longest = 0.0;          ///< s, from frame to frame
    double begin_of_longest = 0.0; ///< s
};
[[nodiscard]] TimeGaps time_gaps(std::span<const double> times);

} // namespace culm::measure
