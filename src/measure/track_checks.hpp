// SPDX-License-Identifier: BSD-3-Clause
// Whether what video.toml says agrees with the recording.
#pragma once

#include "measure/frame_source.hpp"
#include "measure/track.hpp"
#include "measure/track_settings.hpp"

#include <string>
#include <vector>

namespace culm::measure {

/// The camera's frames per second: from video.toml, or from a recording that states it. Throws
/// core::InputError if there is none or the two differ by more than a thousandth; a video file's
/// own rate, if it differs, is taken for that of playback and gets a remark.
[[nodiscard]] double camera_rate(const FrameSource& source, const TrackSettings& settings,
                                 std::vector<std::string>& remarks);

/// Young's modulus, Pa, with which a uniform Euler–Bernoulli cantilever of the stem's length,
/// section and density would swing as the recording shows, f = 1.8751²/(2π L²) √(EI/μ). Goes with
/// the square of the frame rate: what pictures alone cannot tell, a person may see in it.
[[nodiscard]] double modulus_of_swing(const Track& track);

/// Adds remarks on what does not fit together: frames that are missing, a swing too fast for the
/// frame rate, a stem of another width or length than the scale says, a modulus that no plant stem
/// has (a wrong rate or scale), a rest position off the stated axis, a pull to the other side.
/// Throws core::InputError if the length seen above a detected clamp is off by more than 15 %: then
/// no height is right.
void add_doubts(Track& track);

} // namespace culm::measure
