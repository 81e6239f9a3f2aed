// SPDX-License-Identifier: BSD-3-Clause
// The stem in one frame: its contrast to the background, the chain of its runs from the clamp
// upward, and its axis in each row; and clutter that never moves.
#pragma once

#include "measure/track/frames/frame_image.hpp"

#include <cstdint>
#include <limits>
#include <vector>

namespace culm::measure {

/// Neighbouring pixels of a row above the threshold: columns begin … end − 1.
struct RowRun {
    int row = 0;
    int begin = 0;
    int end = 0;
    float peak = 0.0F; ///< largest contrast

    [[nodiscard]] int width() const { return end - begin; }
    /// Median of the run's pixel columns: the position that the paper takes.
    [[nodiscard]] double median_column() const { return 0.5 * (begin + end - 1); }
};

struct TraceOptions {
    double stem_width = 1.0;             ///< pixels
    std::vector<float> threshold_by_row; ///< (height), contrast that makes a pixel logical
    std::vector<std::uint8_t> clutter;   ///< (height, width), 1 = not the stem; empty: none
    int bottom_row = 0;                  ///< rows from here down are left out
    double axis_column = std::numeric_limits<double>::quiet_NaN(); ///< at bottom_row, if known
};

struct StemChain {
    std::vector<RowRun> runs; ///< from the lowest row upward, at most one a row
    double score = 0.0;       ///< about the number of rows that show a whole stem
};

/// The continuous chain of runs with the highest score. A run is a candidate if its width is
/// possible for the stem and the picture's side does not cut it; steps from row to row are limited
/// to a slope of one and to gaps of eight stem widths. The score is the number of rows, weighted by
/// the run's share of the stem's width, less penalties for gaps, especially large ones, and
/// sideways steps. The chain is empty if nothing resembles a stem.
[[nodiscard]] StemChain trace_stem(const BandImage& contrast, const TraceOptions& options);

/// Rows below the end of the tip that axis_columns() leaves out.
[[nodiscard]] int oblique_rows(double stem_width);

/// Column of the stem's axis in every row of the picture, NaN where the stem is not seen or
/// something else hides it: the middle between the columns where the contrast is half of that
/// inside the stem, accurate to some tenths of a pixel (match_rows() refines it). It excludes rows
/// whose median is far from the chain's quadratic (a gate only: no position is replaced by the
/// quadratic), rows near the end of the tip, where the cut through the stem is oblique, and single
/// rows that differ from their neighbours.
[[nodiscard]] std::vector<double> axis_columns(const BandImage& contrast, const StemChain& chain,
                                               const TraceOptions& options);

/// `sign` times (grey value − background), where the background of a pixel is the median of its row
/// in a window of eight stem widths. A thin upright stem has a high contrast; slow changes of the
/// light and wide bodies do not. `sign` is +1 for a stem brighter than its background, −1 for a
/// darker one; `stem_width` in pixels.
[[nodiscard]] BandImage stem_contrast(const BandImage& image, int sign, double stem_width);

/// Standard deviation of a contrast picture's background, grey values: that of the smallest nine
/// tenths of the absolute values, corrected for the cut, and at least 0.25, the resolution of 8
/// bits.
[[nodiscard]] double contrast_noise(const BandImage& contrast);

/// Pixels with a high contrast in all of these pictures that are not the stem, grown by one pixel;
/// (height, width), 1 = clutter. The still part of the stem above its clamp has a high contrast in
/// all pictures too; it is recognised because the moving part continues it. Empty if too little
/// moves.
[[nodiscard]] std::vector<std::uint8_t> find_still_clutter(const std::vector<BandImage>& contrasts,
                                                           const TraceOptions& options);

} // namespace culm::measure
