// SPDX-License-Identifier: BSD-3-Clause
// The columns of a stem's axis in all frames, by picture row and at chosen heights, and the motion
// that they show: release, swing, and frames that are missing.
#pragma once

#include "measure/release/swing_release.hpp"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace culm::measure {

/// Columns of the axis in the upright picture, pixels; NaN where the stem was not seen.
struct AxisRecord {
    std::vector<int> numbers;    ///< (frames), of the recording, ascending
    std::vector<double> times;   ///< (frames), of FrameClock
    std::vector<double> places;  ///< rows of the picture, or heights in pixels above the clamp
    std::vector<double> columns; ///< (frames, places) row-major
    std::vector<double> uncertainties; ///< of them, standard, pixels; NaN where not known

    [[nodiscard]] double at(std::size_t frame, std::size_t place) const {
        return columns[frame * places.size() + place];
    }
    /// Whether the frames last equally long.
    [[nodiscard]] bool is_even() const { return std::ranges::equal(times, numbers); }
    /// Columns at one location, (frames).
    [[nodiscard]] std::vector<double> history(std::size_t place) const;
    /// Fraction of the frames in which the location was seen.
    [[nodiscard]] double seen(std::size_t place) const;
};

/// The values that are not NaN.
[[nodiscard]] std::vector<double> known(std::span<const double> values);

/// Heights, in pixels above the clamp, from a step up to the highest row that was seen in nine of
/// ten frames. `step` in pixels; 0: about 20 heights, a whole number of millimetres (or 1, 2, 5 of
/// a lower power of ten) apart.
[[nodiscard]] std::vector<double> spaced_heights(const AxisRecord& rows, double clamp_row,
                                                 double step, double millimetres_per_pixel);

/// The columns at heights: a straight line through the nearest `rows_per_height` rows of each
/// height (1: the two rows between which the height lies). NaN where fewer than half of them were
/// seen or the height is outside the seen rows.
[[nodiscard]] AxisRecord at_heights(const AxisRecord& rows, double clamp_row,
                                    const std::vector<double>& heights, int rows_per_height);

/// y(n+2L) − c = a (y(n+L) − c) + b (y(n) − c) for every damped sine, with any phase and amplitude:
/// a = 2 exp(−αL) cos ωL, b = −exp(−2αL). All locations share a and b; each has its own c.
struct SwingModel {
    int lag = 1; ///< L, frames
    double a = 0.0;
    double b = 0.0;
};

/// Linear least squares over the frames begin … end − 1 (indices), with a lag of about an eighth of
/// the period (in frames). Triples with a missing frame are excluded. Empty if fewer than a dozen
/// remain.
[[nodiscard]] std::optional<SwingModel> fit_swing(const AxisRecord& record, std::size_t begin,
                                                  std::size_t end, double period);

/// Residual of the recurrence in one history, whose rest is c: y(n+2L) less its prediction from
/// y(n+L) and y(n), at the index of n+2L; NaN if one of the frames is missing.
[[nodiscard]] std::vector<double> swing_surprises(const std::vector<int>& numbers,
                                                  const std::vector<double>& history,
                                                  const SwingModel& model, double rest);

/// Remarks about frames of a location before which some were lost or doubled. While higher modes
/// are present, a jump changes the times between passages through the rest by 4 % of a period.
/// Later, the residual of the recurrence `model` (lag 1) is an eighth of the amplitude or more.
/// `settled` is the index of the frame from which on the first mode swings alone;
/// `relative_height` that of the location over the stem's length.
[[nodiscard]] std::vector<std::string> find_jumps(const std::vector<int>& numbers,
                                                  const std::vector<double>& history,
                                                  const SwingRelease& release,
                                                  double relative_height, const SwingModel& model,
                                                  std::size_t settled);

} // namespace culm::measure
