// SPDX-License-Identifier: BSD-3-Clause
// When the stem was released, when it came to rest, where rest is, and how noisy a reading is.
#pragma once

#include "measure/row_record.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace culm::measure {

/// How the rest position was found.
enum class RestSource {
    FramesAtRest, ///< median of the frames after the motion has died down
    DecayingSwing ///< the recording ends before: the centre of the decaying swing (swing_model.hpp)
};

struct RingDownWindow {
    std::size_t last_held = 0;   ///< index of the last frame in which the stem is held still
    std::size_t held_frames = 0; ///< before it and with it, still held at the same place
    double release_number = 0.0; ///< frame number, with fraction, at which it was let go
    std::optional<std::size_t> rest_begin; ///< index of the first frame at rest
    RestSource rest_source = RestSource::FramesAtRest;
    std::vector<double> rest;      ///< (places) column, pixels
    double sign = 1.0;             ///< −1 if it was pulled toward smaller columns
    std::size_t watched = 0;       ///< the place
    double pull = 0.0;             ///< deflection while held, at the place watched, pixels, > 0
    double cycles_per_frame = 0.0; ///< of the swing
    std::vector<double> noise; ///< (places) standard deviation of a reading, pixels; NaN unknown
    std::string noise_source;  ///< from which frames
    /// (places) what the swing's recurrence leaves, as a reading's standard deviation, pixels: also
    /// holds errors that a still stem does not show. Empty if the swing is too short.
    std::vector<double> moving_noise;
    std::vector<std::string> remarks;
};

struct WindowOptions {
    std::string source;                       ///< what messages call the recording
    double length = 0.0;                      ///< of the stem, pixels
    std::optional<std::size_t> release_frame; ///< index of the last held frame, if given
};

/// Watches the highest place that is seen in nearly all frames and throughout the release. Release:
/// from the largest deflection that is followed by a swing back, the last frame at the held
/// position, and the moment from which a cantilever's release curve follows (release_moment.hpp).
/// Rest: from where a period's range stays within the noise. Noise: the spread while held (at least
/// 5 frames), else at rest, else of what the swing's recurrence leaves. Remarks tell of a release
/// that was no sudden one and of jumps that look like frames lost without a gap in the numbers.
/// Throws core::InputError, saying what was seen, if the stem does not move, is never let go, does
/// not swing, or was let go before the first frame.
[[nodiscard]] RingDownWindow find_ring_down(const AxisRecord& record, const WindowOptions& options);

} // namespace culm::measure
