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
    double number = 0.0;          ///< frame number with fraction
    double misfit = 0.0;          ///< largest difference from the release curve there, of the pull
    double sign = 1.0;            ///< of the pull
    double pull = 0.0;            ///< held column less the rest, times sign, pixels, > 0
    double held_noise = 0.0;      ///< robust spread of the held columns, pixels
    double period = 0.0;          ///< mean over the swings seen, frames
    std::vector<double> passages; ///< through the rest, frame numbers with fractions
};

/// What is known before the release is looked for.
struct ReleaseClues {
    double rest = 0.0;                    ///< column, an estimate
    double relative_height = 1.0;         ///< of the place, of the stem's length
    double decay_per_cycle = 0.0;         ///< of the swing; 0 if not known yet
    std::optional<std::size_t> last_held; ///< index of the frame, if the user says so
};

/// The moment is that from which the first tenth of a swing follows a cantilever's release curve
/// (release_curve.hpp) best. Throws core::InputError (beginning with `source`) if the history does
/// not show a stem that is held, let go, and swings through its rest. Still means longer than the
/// turning point of such a swing would seem to be.
[[nodiscard]] ReleaseMoment find_release(const WatchedHistory& history, const ReleaseClues& clues,
                                         const std::string& source);

} // namespace culm::measure
