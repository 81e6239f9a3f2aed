// SPDX-License-Identifier: BSD-3-Clause
// The release in one history of deflections.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace culm::measure {

/// The history of one place by frame; NaN where it was not seen.
struct WatchedHistory {
    std::vector<int> numbers;   ///< of the frames
    std::vector<double> column; ///< pixels
};

struct ReleaseMoment {
    std::size_t last_held = 0;
    std::size_t held_frames = 0;
    double number = 0.0;     ///< frame number with fraction
    double sign = 1.0;       ///< of the pull
    double pull = 0.0;       ///< held column less the rest, times sign, pixels, > 0
    double held_noise = 0.0; ///< robust spread of the held columns, pixels
    double period = 0.0;     ///< mean over the swings seen, frames
};

/// `rest` is an estimate of the rest column. Throws core::InputError (beginning with `source`) if
/// the history does not show a stem that is held, let go, and swings through its rest.
[[nodiscard]] ReleaseMoment find_release(const WatchedHistory& history, double rest,
                                         std::optional<std::size_t> given_last_held,
                                         const std::string& source);

} // namespace culm::measure
