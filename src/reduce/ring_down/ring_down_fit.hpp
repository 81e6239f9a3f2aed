// SPDX-License-Identifier: BSD-3-Clause
// Eq. 1 of Schramm et al. (2019) fitted to a deflection history: initial amplitude, decay,
// frequency.
#pragma once

#include "reduce/distributions.hpp"

#include <cstddef>
#include <numbers>
#include <optional>
#include <span>

namespace culm::reduce {

struct RingDownFitOptions {
    /// Free: b0 is fitted. Fixed: b0 is the deflection at release over the largest one (1 for a
    /// stem that starts from its largest deflection).
    bool amplitude_is_free = true;
    /// Only samples with 0 <= t <= window are used, s; empty: all samples from the release on.
    std::optional<double> window;
    /// A motion that decays by more than this per cycle (as an exponent) has no well-defined period
    /// and is refused. 2π is about 71 % of critical damping.
    double largest_decay_per_cycle = 2.0 * std::numbers::pi;
};

/// y(t) = deflection_scale · amplitude · exp(decay_rate t) · cos(2π frequency t).
struct RingDownFit {
    double amplitude = 0.0;       ///< b0, in units of deflection_scale; negative for a stem that is
                                  ///< released from the negative side
    double decay_rate = 0.0;      ///< b1, 1/s; negative for a motion that dies away
    double frequency = 0.0;       ///< b2, Hz
    double decay_per_cycle = 0.0; ///< b1/b2: the paper's b1 in normalised time; −2πζ for small ζ
    double deflection_scale = 0.0; ///< largest absolute deflection among the samples used, m

    // The intervals assume residuals that are independent and of one variance; they are only
    // indicative where Eq. 1 itself is inaccurate.
    Estimate amplitude_uncertainty; ///< of width zero if b0 was fixed
    Estimate decay_rate_uncertainty;
    Estimate frequency_uncertainty;
    Estimate decay_per_cycle_uncertainty; ///< from the full covariance of b1 and b2

    double rms_residual = 0.0; ///< root of the mean squared residual, in units of deflection_scale
    double r_squared = 0.0;    ///< share of the variance about the mean that is explained
    int iterations = 0;        ///< of the optimiser, from the best start
    std::size_t samples = 0;   ///< used by the fit
};

/// Fits Eq. 1 by nonlinear least squares to the samples (times in s, strictly ascending, 0 =
/// release; deflections in m; equal length). Deflections are normalised by their largest absolute
/// value, time by the period of the start. The starts come from a scan of the whole plane of
/// frequency (up to half the sampling rate) and decay, so the fit does not converge to a wrong
/// period. The result is the minimum to about 1e-10 relative. Throws core::NumericalError
/// (FitFailed) for too few samples, times out of order, values that are not finite, constant or
/// near-critically damped signals, and for histories too short or too noisy to determine the
/// frequency; with amplitude_is_free = false also if no sample gives the deflection at the release.
[[nodiscard]] RingDownFit fit_ring_down(std::span<const double> times,
                                        std::span<const double> deflections,
                                        const RingDownFitOptions& options = {});

} // namespace culm::reduce
