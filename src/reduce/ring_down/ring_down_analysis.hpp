// SPDX-License-Identifier: BSD-3-Clause
// Fits Eq. 1 to one measured history, with intervals that remain valid for correlated residuals and
// a test whether Eq. 1 suffices.
#pragma once

#include "reduce/ring_down/ring_down_fit.hpp"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace culm::reduce {

struct RingDownAnalysisOptions {
    /// Only samples with 0 <= t <= window are used, s; empty: all from the release on.
    std::optional<double> window;
    /// y = offset + Eq. 1: for a stem that comes to rest away from zero.
    bool has_offset = false;
    /// cos(2π b2 t + φ) instead of cos(2π b2 t): for an uncertain release time, and because
    /// a damped stem starts at speed zero, which Eq. 1 does not (for the bias see
    /// docs/fit-format.md).
    bool has_phase = false;
    /// Standard deviation of one reading, m; empty: not known.
    std::optional<double> noise;
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

struct RingDownAnalysis {
    Estimate amplitude;              ///< b0, m
    Estimate decay_rate;             ///< b1, 1/s
    Estimate frequency;              ///< b2, Hz
    Estimate decay_per_cycle;        ///< b1/b2, the paper's b1 in normalised time
    Estimate offset;                 ///< m; 0 unless it is fitted
    Estimate phase;                  ///< rad; 0 unless it is fitted
    double rms_residual = 0.0;       ///< m
    double largest_deflection = 0.0; ///< of the samples used, m
    double r_squared = 0.0;
    /// Standard error of b1 per cycle if the residuals were independent. The reported one over this
    /// is the effect of their correlation.
    double independent_decay_error = 0.0;
    std::size_t samples = 0;
    RingDownAdequacy adequacy;
    std::vector<double> residuals; ///< (samples), measured − fitted, m
};

/// Fits and judges a history (times in s, strictly ascending; deflections in m; NaN for gaps, which
/// are left out). The covariance of the parameters is (JᵀJ)⁻¹ S (JᵀJ)⁻¹; each variance is the
/// largest of three estimates of S: σ² JᵀJ (independent residuals), Jᵀ Γ J with the residuals'
/// autocovariance (stationary noise), and the one of Newey & West (1987), which is also valid if
/// the misfit decays with the motion. Lags extend over one period. Throws core::NumericalError
/// (FitFailed) as fit_ring_down does.
[[nodiscard]] RingDownAnalysis analyse_ring_down(std::span<const double> times,
                                                 std::span<const double> deflections,
                                                 const RingDownAnalysisOptions& options = {});

} // namespace culm::reduce
