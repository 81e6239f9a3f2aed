// SPDX-License-Identifier: BSD-3-Clause
// The fit of Eq. 1 of Schramm et al. (2019) to a deflection history: initial amplitude, decay and
// frequency, with a phase and an offset as options.
//
// The covariance of the parameters is (JᵀJ)⁻¹ S (JᵀJ)⁻¹. For a simulated history S = σ² JᵀJ:
// residuals independent, of one variance. For a measured one each variance is the largest of three:
// this one, Jᵀ Γ J with the autocovariance of the residuals (stationary noise), and that of Newey &
// West (1987), which is also valid if the misfit decays with the motion. Lags extend over a period.
//
// Traps. The intervals are only indicative where Eq. 1 itself is inaccurate. A damped stem starts
// at speed zero, which Eq. 1 without a phase does not (for the bias see docs/fit-format.md).
#pragma once

#include "reduce/distributions.hpp"

#include <cstddef>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace culm::reduce {

struct RingDownOptions {
    /// Only samples with 0 <= t <= window are used, s; empty: all samples from the release on.
    std::optional<double> window = {};
    /// y = offset + Eq. 1: for a stem that comes to rest away from zero.
    bool has_offset = false;
    /// cos(2π b2 t + φ) instead of cos(2π b2 t): for an uncertain release time.
    bool has_phase = false;
    /// Free: b0 is fitted. Fixed: b0 is the deflection at the release; not with a phase.
    bool amplitude_is_free = true;
    /// NaN are gaps, the intervals hold for correlated residuals, and the residuals are tested.
    bool is_measured = false;
    /// Standard deviation of one reading, m; empty: not known.
    std::optional<double> noise = {};
    /// A motion that decays by more than this per cycle (as an exponent) has no well-defined period
    /// and is refused. 2π is about 71 % of critical damping.
    double largest_decay_per_cycle = 2.0 * std::numbers::pi;
};

/// Tests whether the residuals are noise. A p-value is the probability of residuals at least as
/// extreme as these if Eq. 1 is the complete model.
struct RingDownAdequacy {
    double ljung_box_p_value =
        1.0;                   ///< of correlation over lags up to a period, at most a fifth of n
    double runs_p_value = 1.0; ///< of the signs
    std::optional<double> reduced_chi_squared; ///< against the noise, if it is known
    std::optional<double> chi_squared_p_value;
    bool is_adequate = true; ///< no p-value below 0.01
    std::string reason;      ///< why not
};

struct RingDownFit {
    Estimate amplitude;       ///< b0, m; negative for a release from the negative side
    Estimate decay_rate;      ///< b1, 1/s; negative for a motion that dies away
    Estimate frequency;       ///< b2, Hz
    Estimate decay_per_cycle; ///< b1/b2: the paper's b1 in normalised time; −2πζ for small ζ
    Estimate offset;          ///< m; 0 unless it is fitted
    Estimate phase;           ///< rad; 0 unless it is fitted
    double largest_deflection = 0.0; ///< of the samples used, m
    double rms_residual = 0.0;       ///< m
    double r_squared = 0.0;          ///< share of the variance about the mean that is explained
    /// Standard error of b1 per cycle if the residuals were independent. The reported one over this
    /// is the effect of their correlation.
    double independent_decay_error = 0.0;
    std::size_t samples = 0;       ///< used by the fit
    RingDownAdequacy adequacy;     ///< of a measured history
    std::vector<double> residuals; ///< (samples), measured − fitted, m
};

/// Fits Eq. 1 by nonlinear least squares to the samples (times in s, strictly ascending, 0 =
/// release; deflections in m; equal length). The starts come from a scan of the whole plane of
/// frequency (up to half the sampling rate) and decay, so the fit does not converge to a wrong
/// period. The result is the minimum to about 1e-10 relative. Throws core::NumericalError
/// (FitFailed) for too few samples, times out of order, values that are not finite, constant or
/// near-critically damped signals, and for histories too short or too noisy to determine the
/// frequency; with a fixed amplitude also if no sample gives the deflection at the release.
[[nodiscard]] RingDownFit fit_ring_down(std::span<const double> times,
                                        std::span<const double> deflections,
                                        const RingDownOptions& options = {});

} // namespace culm::reduce
