// SPDX-License-Identifier: BSD-3-Clause
// Several damped modes, fitted to the histories of several heights at once.
//
//     y_j(t) = o_j + Σ_k e^(b_k t) (c_jk cos ω_k t − s_jk sin ω_k t)
//
// is linear in the offsets o and the amplitudes c, s of each height j, and all heights have the
// same b_k and ω_k. The linear numbers are eliminated (variable projection: Golub & Pereyra 1973,
// with Kaufman's derivative 1975), so that the search has two numbers a mode. Their covariance is
// the larger of σ² (JᵀJ)⁻¹ and the one of Newey & West (1987), for residuals that are correlated
// over up to a period of the slowest mode.
//
// Traps. The sum of squares has a minimum near every frequency of the histories: starts must be
// within about half a cycle over the record. A mode whose frequency changes with the amplitude is
// fitted by its mean frequency.
#pragma once

#include "reduce/distributions.hpp"

#include <complex>
#include <optional>
#include <span>
#include <vector>

namespace culm::reduce {

/// Histories of several heights at the same times; NaN: not seen.
struct HeightHistories {
    std::vector<double> times;                  ///< s, ascending
    std::vector<std::vector<double>> histories; ///< (heights, times)
    std::vector<double> weights;                ///< (heights) 1/noise, or 1/scale
};

struct ModeRate {
    double decay_rate = 0.0; ///< b, 1/s; negative
    double frequency = 0.0;  ///< Hz
    bool is_free = true;     ///< false: only its amplitudes are fitted
};

struct DampedMode {
    ModeRate rate;
    double decay_error = 0.0;     ///< standard errors
    double frequency_error = 0.0; ///< Hz
    /// (heights) c + i s: the motion is Re[(c + i s) e^((b + iω) (t − t₀))], t₀ the first time.
    std::vector<std::complex<double>> amplitudes;
    std::vector<double> amplitude_errors; ///< (heights) standard errors

    /// −b/|b + iω|, damped.
    [[nodiscard]] double damping_ratio() const;
    [[nodiscard]] double damping_ratio_error() const;
    /// Index of the height at which the mode is largest over its error.
    [[nodiscard]] std::size_t largest_height() const;
};

/// Amplitudes at the heights, at the first time; SI units of the readings.
template <class To>
void describe(To& to, const DampedMode& mode) {
    to("frequency_hz", mode.rate.frequency);
    to("frequency_stderr_hz", mode.frequency_error);
    to("damping_ratio", [&] { return mode.damping_ratio(); });
    to("damping_ratio_stderr", [&] { return mode.damping_ratio_error(); });
    to("amplitudes", [&] {
        std::vector<double> sizes;
        for (const std::complex<double>& amplitude : mode.amplitudes)
            sizes.push_back(std::abs(amplitude));
        return sizes;
    });
}

struct DampedModesFit {
    std::vector<DampedMode> modes;
    std::vector<double> offsets;                ///< (heights)
    double weighted_rms = 0.0;                  ///< of the residuals times their weights
    std::size_t samples = 0;                    ///< that were seen
    std::vector<std::vector<double>> residuals; ///< (heights, times) measured − fitted; NaN
};

/// The same from `begin` to `end`, s.
[[nodiscard]] HeightHistories part_of(const HeightHistories& of, double begin, double end);

template <class To>
void describe(To& to, const DampedModesFit& fit) {
    to("modes", fit.modes);
    to("samples", fit.samples);
}

/// The minimum that these starts lead to, with an offset at every height; empty if there is none:
/// fewer samples than numbers, or a frequency that leaves the neighbourhood of its start.
[[nodiscard]] std::optional<DampedModesFit> fit_damped_modes(const HeightHistories& of,
                                                             std::span<const ModeRate> starts);

/// The first `count` modes of the histories: Eq. 1 at the best height, then the strongest higher
/// frequencies in what remains of the first cycles. Fewer where no other mode stands out.
[[nodiscard]] std::vector<ModeRate> visible_modes(const HeightHistories& of, std::size_t count);

} // namespace culm::reduce
