// SPDX-License-Identifier: BSD-3-Clause
// The error of an explicit step in the first vibrating mode of a linearised chain.
#pragma once

#include "integrate/modes.hpp"

#include <complex>
#include <optional>

namespace culm::integrate {

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
