// SPDX-License-Identifier: BSD-3-Clause
// How a linearised chain vibrates: frequencies, decay, and the stability and error of an explicit
// step.
// physics::first_frequency() is the frequency of the slender beam; run/modes.hpp applies both to a
// case. There is no other code for frequencies of the model.
#pragma once

#include "integrate/linearised.hpp"

#include <complex>
#include <cstddef>
#include <optional>
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

/// The vibrating modes (complex pairs), slowest first, `count` of them at most.
[[nodiscard]] std::vector<VibrationMode> vibration_modes(const LinearisedChain& chain,
                                                         std::size_t count);

/// The first of transverse_modes() to first order in the damping, by inverse iteration, which costs
/// much less than all modes: its frequency is the natural one. NaN if the stiffness is singular or
/// the chain leans further.
[[nodiscard]] VibrationMode lightly_damped_mode(const physics::Chain<2, double>& chain);

/// The largest step (s) for which velocity Verlet, with damping evaluated from the half-step
/// velocity, is stable for the linearised chain: the one-step map's spectral radius is 1 there.
[[nodiscard]] double largest_stable_step(const LinearisedChain& chain);

/// The first of vibration_modes(), at a small part of its cost: Newton's method on
/// (λ²M + λC + K) u = 0 (inverse iteration: Ruhe 1973, SIAM J. Numer. Anal. 10:674) from the mode
/// without damping. If this finds no vibration near the undamped mode, for example because damping
/// is nearly aperiodic, all modes are computed. Empty if none vibrates.
[[nodiscard]] std::optional<VibrationMode> slowest_mode(const LinearisedChain& chain);

/// The slowest transverse modes of a planar chain with effects, at most `count`; none if it does
/// not vibrate. Effects are linearised about the straight line, so that quadratic drag has no
/// influence. Maxwell branches stiffen all modes alike, by the factor at the first mode's
/// frequency.
[[nodiscard]] std::vector<VibrationMode> transverse_modes(const physics::Chain<2, double>& chain,
                                                          std::size_t count);

/// Relative errors, (with the step − exact)/exact.
struct StepError {
    double decay_per_cycle; ///< of b1 per cycle; NaN for an undamped mode
    double frequency;       ///< of b2
};

/// Velocity Verlet with damping from the half-step velocity turns λ²M + λC + K into
///     (2 sinh(λh/2)/h)² M + ((1 − e^(−λh))/h) C + K,
/// which is singular at the λ of the discrete motion. The matrix of the exact mode is perturbed by
/// −λ²h/2 C + λ⁴h²/12 M + …; the effect on λ follows from the left and right eigenvectors to first
/// order. This resolves errors of 1e-9; the difference of two eigenvalue computations of a stiff
/// chain does not.
class FirstModeStepError {
  public:
    /// The errors in the slowest vibrating mode; nothing if no mode vibrates.
    [[nodiscard]] static std::optional<FirstModeStepError> of(const LinearisedChain& chain);

    /// The errors for a step (s) that is short relative to the mode's period.
    [[nodiscard]] StepError at(double step) const;

    /// λ of the exact mode, 1/s.
    [[nodiscard]] std::complex<double> eigenvalue() const { return eigenvalue_; }

  private:
    FirstModeStepError() = default;

    std::complex<double> eigenvalue_;
    std::complex<double> mass_;    ///< w·Mu / w·(2λM + C)u with the left and right vectors w, u
    std::complex<double> damping_; ///< w·Cu / the same
};

} // namespace culm::integrate
