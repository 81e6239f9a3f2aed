// SPDX-License-Identifier: BSD-3-Clause
// The motion of a cantilever that was held at its tip and is let go.
#pragma once

namespace culm::measure {

/// Motion that is expected after a release. Times are in any unit, that of the period.
struct ReleaseCurve {
    double relative_height = 1.0; ///< of the location, over the stem's length
    double period = 1.0;          ///< of the first mode
    double decay_per_cycle = 0.0; ///< of the first mode's amplitude, 2πζ, ≥ 0

    /// Deflection over the held one at a time after the release (1 before it): the first eight
    /// modes of a uniform Euler–Bernoulli cantilever that was bent by a force at its tip, each
    /// damped in proportion to its frequency (Kelvin–Voigt). The tip starts at once, lower
    /// locations when the bending wave has reached them.
    [[nodiscard]] double at(double time) const;

    /// Time from the release to the first passage through the rest position.
    [[nodiscard]] double first_passage() const;
};

} // namespace culm::measure
