// SPDX-License-Identifier: BSD-3-Clause
// When and from where a stem was let go: one definition for pictures, tables and sensors.
//
// The release is the last time at which the motion leaves a rest that is away from the final
// position. Let x(t) pass its final position c at the times p₁ < p₂ < …; a free swing passes it
// every half period T/2. The stem was held before the last passage that comes more than T/2 after
// the one before. With a straight line L(t) through the held readings (a hand drifts) and a curve R
// of a cantilever that is let go,
//     x(t) = L(t),                      t < t₀,
//     x(t) = c + (L(t₀) − c) R(t − t₀), t ≥ t₀.
//
// Traps: a pull by hand is as fast as the swing, so fast motion alone does not show a release. The
// noise of many readings hides a slow start, so that the first distinct reading is late, by more
// the faster the readings are. A finger that opens slowly lets the stem go over a time d; then R is
// the mean of curves that begin within d. Which R is right is not known: t₀ is the mean over curves
// and d, each weighted by its likelihood. Its variance includes their scatter and d²/6: the opening
// begins and ends 1.2 standard deviations from its middle, which is t₀.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace culm::measure {

struct SwingRelease {
    double time = 0.0;              ///< t₀, on the clock of the readings
    double uncertainty = 0.0;       ///< of it, standard
    double held = 0.0;              ///< L(t₀)
    double held_begin = 0.0;        ///< first time from which all readings are near L(t₀)
    double noise = 0.0;             ///< standard deviation of a held reading about L
    std::size_t held_count = 0;     ///< readings that L is fitted to
    double rest = 0.0;              ///< c
    double period = 0.0;            ///< T, of the first swings
    double decay_per_cycle = 0.0;   ///< of their amplitude, logarithmic
    std::vector<double> passages{}; ///< p, after the release
};

/// The release in a history of positions at ascending times; NaN is a gap. `relative_height` is
/// that of the readings over the stem's length. `last_held`: the time of the last reading before
/// the release, if it is known. Throws core::InputError, which names no file, if the history shows
/// no stem that is held, let go, and swings through its final position twice.
[[nodiscard]] SwingRelease find_swing_release(std::span<const double> times,
                                              std::span<const double> positions,
                                              double relative_height,
                                              std::optional<double> last_held = std::nullopt);

/// Twice the mean time between two or more passages. A wrong centre makes the halves of a period
/// unequal, not their mean.
[[nodiscard]] double mean_period(std::span<const double> passages);

/// The position about which a history swings from the time `begin` on: the constant of a
/// least-squares fit of one damped sine to the last cycles; the mean if it does not swing. NaN
/// without a reading. `expected_period` is used if too few swings remain to see it; 0: not known.
[[nodiscard]] double centre_of_swing(std::span<const double> times,
                                     std::span<const double> positions, double begin,
                                     double expected_period = 0.0);

/// Standard deviation of the readings from the time `begin` on, of the last three cycles at
/// most, about one sine of about this period and decay. NaN of fewer than twelve.
[[nodiscard]] double scatter_about_swing(std::span<const double> times,
                                         std::span<const double> positions, double begin,
                                         double period, double decay_per_cycle);

} // namespace culm::measure
