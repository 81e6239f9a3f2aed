// SPDX-License-Identifier: BSD-3-Clause
// Columns of the stem's axis in all frames: by picture row, and at chosen heights.
#pragma once

#include <cstddef>
#include <vector>

namespace culm::measure {

/// Columns of the axis in the upright picture, pixels; NaN where the stem was not seen.
struct AxisRecord {
    std::vector<int> numbers;    ///< (frames), of the recording, ascending
    std::vector<double> places;  ///< rows of the picture, or heights in pixels above the clamp
    std::vector<double> columns; ///< (frames, places) row-major
    std::vector<double> uncertainties; ///< of them, standard, pixels; NaN where not known

    [[nodiscard]] double at(std::size_t frame, std::size_t place) const {
        return columns[frame * places.size() + place];
    }
    /// Columns at one place, (frames).
    [[nodiscard]] std::vector<double> history(std::size_t place) const;
    /// Frames in which the place was seen, as a fraction.
    [[nodiscard]] double seen(std::size_t place) const;
};

/// Heights, in pixels above the clamp, from a step up to the highest row that was seen in nine of
/// ten frames. `step` in pixels; 0: about 20 heights, a whole number of millimetres (or 1, 2, 5 of
/// a lower power of ten) apart.
[[nodiscard]] std::vector<double> spaced_heights(const AxisRecord& rows, double clamp_row,
                                                 double step, double millimetres_per_pixel);

/// The columns at heights: a straight line through the rows nearest to each, as many as
/// `rows_per_height` (1: the two rows between which the height lies). NaN where fewer than half of
/// them were seen or the height lies outside those seen.
[[nodiscard]] AxisRecord at_heights(const AxisRecord& rows, double clamp_row,
                                    const std::vector<double>& heights, int rows_per_height);

} // namespace culm::measure
