// SPDX-License-Identifier: BSD-3-Clause
// Frequencies and decay of a case's chain at small amplitudes (integrate/modes.hpp finds them).
#pragma once

#include "integrate/modes.hpp"
#include "run/case_spec.hpp"

#include <cstddef>
#include <vector>

namespace culm::run {

/// The slowest transverse modes of the case in the plane of the pull, with its effects except those
/// that leave the plane and dry friction: integrate::transverse_modes().
[[nodiscard]] std::vector<integrate::VibrationMode> chain_modes(const CaseSpec& spec,
                                                                std::size_t count);

/// A mode, and what the case's sensors read of its shape, whose deflection is 1 at the tip.
struct ShapedMode {
    integrate::VibrationMode mode;
    /// Deflection of the tip in this mode over that of a stem that is pulled at its tip.
    double pull_share = 0.0;
    /// (heights) the deflection of the shape; of a sensor its reading, in which the shape stands
    /// for the deflections, the velocities or the accelerations.
    std::vector<double> reading;
};
/// The slowest transverse modes of the case, their shapes those of the undamped chain; at most
/// `count`.
[[nodiscard]] std::vector<ShapedMode> shaped_modes(const CaseSpec& spec, std::size_t count);

/// The first mode of the case's chain: known masses count, effects do not. Throws
/// core::NumericalError if it does not vibrate.
[[nodiscard]] integrate::VibrationMode first_mode(const CaseSpec& spec);

/// The first of chain_modes() to first order in the damping, at a small part of its cost; its
/// frequency is the natural one. NaN if the straight chain is unstable.
[[nodiscard]] integrate::VibrationMode lightly_damped_mode(const CaseSpec& spec);

/// Period of the first bending mode of the bare stem without damping, s.
[[nodiscard]] double undamped_period(const CaseSpec& spec);

} // namespace culm::run
