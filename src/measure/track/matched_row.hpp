// SPDX-License-Identifier: BSD-3-Clause
// A row of the picture: the ground, the stem in front of it, and the stem's position.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace culm::measure {

/// Columns begin … end − 1 of a row.
struct Pixels {
    int begin;
    int end;
};

struct PixelRow {
    const float* values;         ///< grey, or less grey: of a dark stem
    const std::uint8_t* clutter; ///< 1 = not the stem nor its background; null: none
    int width;

    [[nodiscard]] bool counts(int column) const { return !clutter || clutter[column] == 0; }
    [[nodiscard]] Pixels within(double column, double distance) const;
};

/// Path of the axis during the exposure, about its mean, pixels.
struct Path {
    double length = 0.0; ///< speed times exposure
    double bend = 0.0;   ///< half the acceleration times the exposure's square

    /// Upper bound of the range of the axis.
    [[nodiscard]] double extent() const { return std::abs(length) + 0.25 * std::abs(bend); }
};

/// Contrast as a function of a pixel's distance from the stem's axis. It includes the edge blur of
/// lens and pixel and the light on the stem, so that none of these shifts a reading.
class StemProfile {
  public:
    /// `reach`: the largest distance that is used, pixels.
    explicit StemProfile(double reach);

    /// Adds the pixels of a row with the axis at `axis`, relative to the straight line through the
    /// pixels next to the stem.
    void add(const PixelRow& row, double axis);

    /// Least squares for a cubic spline through the added pixels, unless they are too few.
    void close();
    [[nodiscard]] bool is_known() const { return !values_.empty(); }

    struct Point {
        double value; ///< grey values
        double slope; ///< per pixel
    };
    /// Mean over a moving stem, at the distance from the mean of its axis. A stem near its turning
    /// point leaves more light at one end of its smear; the assumption of an even speed would shift
    /// readings by up to half a pixel in fast swings.
    [[nodiscard]] Point at(double distance, const Path& path) const;
    /// Distance up to which pixels next to the stem are used for its background.
    [[nodiscard]] double beside() const { return 2.0 * reach_; }

  private:
    [[nodiscard]] double spline(double place) const;
    /// Mean over a part of the path at an even speed, which is seen from `low` to `high`.
    [[nodiscard]] Point between(double low, double high) const;
    [[nodiscard]] double in_table(const std::vector<double>& table, double distance) const;

    double reach_;
    double spacing_; ///< of the knots, pixels
    std::size_t knots_;
    std::vector<double> normal_; ///< (knots, knots) lower part
    std::vector<double> right_;
    std::vector<double> coefficients_;
    std::vector<double> values_;    ///< at even distances
    std::vector<double> integrals_; ///< from −reach
    std::size_t pixels_ = 0;
};

struct RowMatch {
    double axis = 0.0;
    double variance = 0.0; ///< of the axis, pixels², over the pixels' noise² in grey values²
    double squares = 0.0;  ///< of the residuals, grey values²
};

/// Least squares for the axis, the stem's brightness and a straight background line, from an axis
/// accurate to about half a pixel. Empty if the iteration diverges.
[[nodiscard]] std::optional<RowMatch> match_row(const StemProfile& profile, const PixelRow& row,
                                                double axis, const Path& path, double noise);

/// Grey values of a row without the stem.
class GroundRow {
  public:
    /// Pixels within `hidden` of the axis are not ground; NaN: the axis is unknown.
    void add(const PixelRow& row, double axis, double hidden);

    /// Estimate for every pixel: a straight line between pixels seen in at least thirty frames,
    /// from which the ground differs by its texture. The mean of the few frames that show a pixel
    /// is weighted by the variance of the texture relative to their noise (variance `noise`).
    [[nodiscard]] std::vector<float> mean(double noise) const;

  private:
    static constexpr int fewest = 30;

    [[nodiscard]] std::vector<double> between_well_seen() const;
    /// Variance of the ground about the line through well-seen pixels on both sides, estimated from
    /// the middle between two pixels at the same distance, less 1.5 times their noise.
    [[nodiscard]] double texture_of(double noise) const;
    /// Longest run of pixels that were not well seen, between well-seen ones.
    [[nodiscard]] std::size_t widest_gap() const;

    std::vector<double> sums_;
    std::vector<int> counts_;
};

} // namespace culm::measure
