// SPDX-License-Identifier: BSD-3-Clause
// The error terms of a recording about a fit, one function for each kind but the stated inputs.
#pragma once

#include "fit/solve/fit_result.hpp"

#include <optional>
#include <vector>

namespace culm::fit {

/// The error of dividing a stem into spheres, of order 2 in the bond length.
///
/// With y_N the readings of a chain of N bonds and y_2N those of bonds half as long, Y and β
/// matched so that the first mode stays, the stem's are y_N + α (y_2N − y_N), α = 4/3 ± 1/3: the
/// value of order 2 and its doubt. The difference is computed about one fit and is the same for all
/// models. It is not run if the second frequency changes by less than 0.3 standard deviations of
/// the recording, σ_f = √(6/n) σ/(π A T) (Montgomery & O'Donoghue 1999).
struct Division {
    std::vector<double> known;      ///< (times, heights) of the fit, m; empty: negligible
    std::optional<ErrorTerm> doubt; ///< of what is known
    int batches = 0;
};

/// About the published chain without error terms. `noise_model` may be null. Throws as
/// predict_readings().
[[nodiscard]] Division division_of(const RecordingFit& fit, const NoiseModel* noise_model,
                                   const run::Heartbeat& heartbeat);

/// A release by hand: each resolved mode but the first starts with its own amplitude and velocity.
/// If the release was not recorded, they are parameters (fit/chain/higher_modes.hpp).
///
/// About a fit of one recording whose release was recorded; empty unless an exact release shows
/// departures as large as those in the first two periods in at most one case of a thousand.
[[nodiscard]] std::vector<ErrorTerm> release_terms(const Fit& fit,
                                                   const ObservedRecording& recording);

/// A lens or uneven light causes an error that depends on the position in the picture. Each row has
/// its own polynomials of the predicted deflection, and all rows together have those of degree 2
/// and 3 (0 and 1 are the rest position and the scale), each with the stated uncertainty. Near the
/// clamp, where the swing is small, the measured deflection would explain its own noise.
[[nodiscard]] std::vector<ErrorTerm> place_terms(const RecordingFit& fit,
                                                 const measure::Measurement& measurement);

/// A constant error of each sensor, and one that grows linearly in time. By default the constant is
/// about as large as the readings, so that the readings alone determine it.
[[nodiscard]] std::vector<ErrorTerm> sensor_terms(const measure::Measurement& measurement);

/// Errors of a model in the second mode of the stem.
///
/// A recording shows the frequency f₂ and the loss of the second mode better than any chain
/// predicts them: rotary inertia, shear and the dispersion of the material change f₂, and the loss
/// depends on the law of the material. Without these errors the search repairs the second mode with
/// effects that do not act. A loss factor η requires a dispersion by causality: for a nearly
/// constant η, ln E(f₂)/E(f₁) = (2/π) η ln f₂/f₁, and the frequency changes by half of it if all of
/// it is missing and by as much if the law is unknown; the standard uncertainty is
///
///     u(ln f₂) = (2/π) η ln(f₂/f₁),  at least the chain's own error,   u(ln δ₂) = ln 1.5.
///
/// The terms are u ∂y/∂ln f₂ and u ∂y/∂ln δ₂ of the second mode of the linearised chain after a
/// release at rest: at the height z and the time t since the release
///
///     y = Re[B φ₂(z) exp(s₂ t)],   s₂ = −δ₂ + iω₂,   B = a (1 − iδ₂/ω₂),
///
/// where a is the part of the tip's deflection that a pull at the tip gives the second mode. The
/// terms belong to every model: β of the published chain is a law of material damping too.
///
/// Traps: a second mode that is separated from predicted readings takes what a large swing has
/// beyond one harmonic. A reading that is the n-th time derivative of the deflection has B ~ s₂ⁿ,
/// which also changes. Terms about a model whose f₂ is far from that of the recording have the
/// wrong phase after a few cycles.
///
/// The terms about a fit, at its times; a term that the noise hides is omitted. A camera that is
/// too slow for the second mode shows it at another frequency, and so do the terms.
[[nodiscard]] std::vector<ErrorTerm> second_mode_terms(const RecordingFit& fit,
                                                       const measure::Measurement& measurement);

} // namespace culm::fit
