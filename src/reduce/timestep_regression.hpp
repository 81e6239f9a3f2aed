// SPDX-License-Identifier: BSD-3-Clause
// Laws of the largest stable explicit step: how it depends on bond damping and Young's modulus.
#pragma once

#include "reduce/linear_regression.hpp"

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace culm::reduce {

/// The stems whose limit is known; spans of one length.
struct TimestepPoints {
    std::span<const double> bond_youngs_modulus; ///< Y, Pa
    std::span<const double> bond_damping;        ///< β
    std::span<const double> bond_time;           ///< τ = √(m/k_n), s
    std::span<const double> limit;               ///< largest stable step Δt, s
};

/// A fitted law.
struct TimestepLaw {
    LinearRegression regression;   ///< of the law in the form in which it is linear
    std::vector<double> residuals; ///< (points used), Δt observed/fitted − 1
    double largest_residual = 0.0; ///< of their absolute values
};

/// A law, or the reason why the points do not determine it.
struct TimestepLawOutcome {
    std::optional<TimestepLaw> law;
    std::string reason; ///< one sentence if `law` is empty
};

struct TimestepRegression {
    std::size_t points_used = 0;
    std::size_t points_excluded = 0; ///< a value was not finite, or Y, τ or Δt was not positive
    /// Velocity Verlet on one damped oscillator is stable up to the root h of h²ω² + 2hc = 4, with
    /// ω² ∝ 1/τ² and c ∝ β/τ. With u = τ/Δt that is u² = A + B βu: coefficients "A" and "B". Axial
    /// waves of a long chain of equal spheres have A = 1 and, with the damping factor 2 and reduced
    /// masses, B = 2√2.
    TimestepLawOutcome damped_oscillator;
    /// The form of the authors' rule, Δt = τ/(a + bβ): coefficients "a" and "b".
    TimestepLawOutcome rule_form;
    /// ln Δt = ln c + p ln Y + q ln β over the points with β > 0: coefficients "ln_c", "p", "q".
    TimestepLawOutcome power_law;
};

/// Fits the three laws by least squares of relative deviations: rows are divided by their
/// right-hand sides, because limits span orders of magnitude.
/// Throws core::NumericalError (FitFailed) if the spans differ in length.
[[nodiscard]] TimestepRegression regress_timesteps(const TimestepPoints& points);

} // namespace culm::reduce
