// SPDX-License-Identifier: BSD-3-Clause
// The columns of a stem's axis in all frames, by picture row and at chosen heights.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
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

} // namespace culm::measure
