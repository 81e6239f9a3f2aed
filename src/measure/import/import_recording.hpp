// SPDX-License-Identifier: BSD-3-Clause
// Converts a foreign recording to a measurement.
#pragma once

#include "measure/folder/measurement.hpp"
#include "measure/import/import_mapping.hpp"

#include <cstddef>
#include <optional>
#include <span>

namespace culm::measure {

/// Reads the mapping's source and returns a measurement: the mean over the columns or markers of
/// each height, less the motion of the clamp's, relative to the zero that the mapping chooses, with
/// t = 0 at the release; see release_onset() for its detection. If the mapping states no noise, it
/// is the scatter before the release (at least 8 frames), reported in noise_source. Frames in which
/// the stem moves are not used for the noise; a remark reports them. Throws core::InputError.
[[nodiscard]] Measurement import_recording(const ImportMapping& mapping);

struct ReleaseOnset {
    double time = 0.0;        ///< s
    double uncertainty = 0.0; ///< standard uncertainty, s
};
/// The release in a history of positions: where the first fast motion leaves the line on which a
/// hand that moves slowly had led the stem. Between two frames it is interpolated by the root of
/// the travel. Empty if fewer than five frames lie before the motion, or if it starts at once. Gaps
/// are NaN.
[[nodiscard]] std::optional<ReleaseOnset> release_onset(std::span<const double> times,
                                                        std::span<const double> positions);

/// Gaps between consecutive frames that are longer than one and a half usual frame times.
struct TimeGaps {
    std::size_t count = 0;
    double longest = 0.0;          ///< s, from frame to frame
    double begin_of_longest = 0.0; ///< s
};
[[nodiscard]] TimeGaps time_gaps(std::span<const double> times);

} // namespace culm::measure
