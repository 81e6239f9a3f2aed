// SPDX-License-Identifier: BSD-3-Clause
// A row of the picture: the ground, the stem over it, and where it lies.
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

    /// How far the axis comes.
    [[nodiscard]] double extent() const { return std::abs(length) + 0.25 * std::abs(bend); }
};

/// Contrast over the distance of a pixel's middle from the stem's axis. It holds what the lens and
/// the pixel do to an edge and how the light falls on the stem, so none of these moves a reading.
class StemProfile {
  public:
    /// `reach`: the largest distance that counts, pixels.
    explicit StemProfile(double reach);

    /// Takes the pixels of a row in which the axis lies at `axis`, over the straight line through
    /// those next to the stem.
    void add(const PixelRow& row, double axis);

    /// Least squares for a cubic spline through what was added. False if that is too little.
    [[nodiscard]] bool close();

    struct Point {
        double value; ///< grey values
        double slope; ///< per pixel
    };
    /// Mean over a stem that moves, at the distance from the mean of its axis. A stem that turns
    /// leaves more light at one end of its smear: taken for even, it would be read up to half a
    /// pixel off in fast swings.
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

/// Least squares for the axis, the stem's brightness and a straight line for the background's, from
/// an axis that is good to half a pixel or so. Empty if that leads away.
[[nodiscard]] std::optional<RowMatch> match_row(const StemProfile& profile, const PixelRow& row,
                                                double axis, const Path& path, double noise);

/// Grey values of a row where the stem is not.
class GroundRow {
  public:
    /// Pixels within `hidden` of the axis are not the ground; NaN: the axis is not known.
    void add(const PixelRow& row, double axis, double hidden);

    /// What is known of every pixel: between those that were seen in thirty frames or more a
    /// straight line, from which the ground differs by its texture. The mean of the few frames that
    /// show a pixel counts as far as their noise (variance `noise`) leaves that texture to see.
    [[nodiscard]] std::vector<float> mean(double noise) const;

  private:
    static constexpr int fewest = 30;

    [[nodiscard]] std::vector<double> between_well_seen() const;
    /// Variance of the ground about the line through what was well seen on both sides: that about
    /// the middle of two pixels that are as far apart, of whose noise there is half as much again.
    [[nodiscard]] double texture_of(double noise) const;
    /// Pixels in a row that were not well seen, between others.
    [[nodiscard]] std::size_t widest_gap() const;

    std::vector<double> sums_;
    std::vector<int> counts_;
};

} // namespace culm::measure
