// SPDX-License-Identifier: BSD-3-Clause
// How a pulled cantilever leaves its hold, at any height.
#pragma once

namespace culm::measure {

/// Motion by which the readings after a release are understood.
struct ReleaseCurve {
    double relative_height = 1.0; ///< of the place, of the stem's length
    double period = 1.0;          ///< of the first mode, frames
    double decay_per_cycle = 0.0; ///< of the first mode's amplitude, 2πζ, ≥ 0

    /// Deflection over that while held, `frames` after the release (1 before it): the first eight
    /// modes of a uniform Euler–Bernoulli cantilever that a force at its tip held bent, each damped
    /// in proportion to its frequency (Kelvin–Voigt). The tip starts at once, lower places when the
    /// wave of bending has reached them.
    [[nodiscard]] double at(double frames) const;

    /// Frames from the release to the first passage through the rest position.
    [[nodiscard]] double first_passage() const;
};

} // namespace culm::measure
