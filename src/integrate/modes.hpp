// SPDX-License-Identifier: BSD-3-Clause
// How a linearised chain vibrates: frequencies, decay, and the largest stable explicit step.
// physics::first_frequency() is the frequency of the slender beam; run/modes.hpp applies both to a
// case. There is no other code for frequencies of the model.
#pragma once

#include "integrate/linearised.hpp"

#include <cstddef>
#include <vector>

namespace culm::integrate {

/// One vibration mode.
struct VibrationMode {
    double frequency;       ///< Im λ/2π, Hz: b2 of Eq. 1
    double decay_rate;      ///< Re λ, 1/s: b1 of Eq. 1, negative
    double decay_per_cycle; ///< decay_rate/frequency: b1 in normalised time

    /// ζ of decay_per_cycle = −2πζ/√(1 − ζ²).
    [[nodiscard]] double damping_ratio() const;
    /// The frequency without damping, Hz: frequency/√(1 − ζ²).
    [[nodiscard]] double natural_frequency() const;
};

/// The vibrating modes (complex pairs), slowest first, `count` of them at most. Each of a few modes
/// is found by Newton's method on (λ²M + λC + K) u = 0 (inverse iteration: Ruhe 1973, SIAM J.
/// Numer. Anal. 10:674) from a mode without damping. If this finds no vibration near an undamped
/// mode, for example because damping is nearly aperiodic, all modes are computed, at a much higher
/// cost.
[[nodiscard]] std::vector<VibrationMode> vibration_modes(const LinearisedChain& chain,
                                                         std::size_t count);

/// The first of transverse_modes() to first order in the damping, by inverse iteration, which costs
/// much less than all modes: its frequency is the natural one. NaN if the stiffness is singular or
/// the chain leans further.
[[nodiscard]] VibrationMode lightly_damped_mode(const physics::Chain<2, double>& chain);

/// The largest step (s) for which velocity Verlet, with damping evaluated from the half-step
/// velocity, is stable for the linearised chain: the one-step map's spectral radius is 1 there.
[[nodiscard]] double largest_stable_step(const LinearisedChain& chain);

/// The slowest transverse modes of a planar chain with effects, at most `count`; none if it does
/// not vibrate. Effects are linearised about the straight line, so that quadratic drag has no
/// influence. Maxwell branches stiffen all modes alike, by the factor at the first mode's
/// frequency.
[[nodiscard]] std::vector<VibrationMode> transverse_modes(const physics::Chain<2, double>& chain,
                                                          std::size_t count);

} // namespace culm::integrate
