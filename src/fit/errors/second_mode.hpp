// SPDX-License-Identifier: BSD-3-Clause
// Errors of a model in the second mode of the stem.
//
// A recording shows the frequency f₂ and the loss of the second mode better than any chain predicts
// them: rotary inertia, shear and the dispersion of the material change f₂, and the loss depends on
// the law of the material. Without these errors the search repairs the second mode with effects
// that do not act. A loss factor η requires a dispersion by causality: for a nearly constant η,
// ln E(f₂)/E(f₁) = (2/π) η ln f₂/f₁, and the frequency changes by half of it if all of it is
// missing and by as much if the law is unknown; the standard uncertainty is
//
//     u(ln f₂) = (2/π) η ln(f₂/f₁),  at least the chain's own error,   u(ln δ₂) = ln 1.5.
//
// The terms are u ∂y/∂ln f₂ and u ∂y/∂ln δ₂ of the second mode of the linearised chain after a
// release at rest: at the height z and the time t since the release
//
//     y = Re[B φ₂(z) exp(s₂ t)],   s₂ = −δ₂ + iω₂,   B = a (1 − iδ₂/ω₂),
//
// where a is the part of the tip's deflection that a pull at the tip gives the second mode. The
// terms belong to every model: β of the published chain is a law of material damping too.
//
// Traps: a second mode that is separated from predicted readings takes what a large swing has
// beyond one harmonic. A reading that is the n-th time derivative of the deflection has B ~ s₂ⁿ,
// which also changes. Terms about a model whose f₂ is far from that of the recording have the wrong
// phase after a few cycles.
#pragma once

#include "fit/solve/fit_result.hpp"

#include <vector>

namespace culm::fit {

/// The terms about a fit, at its times; a term that the noise hides is omitted. A camera that is
/// too slow for the second mode shows it at another frequency, and so do the terms.
[[nodiscard]] std::vector<ErrorTerm> second_mode_terms(const RecordingFit& fit,
                                                       const measure::Measurement& measurement);

} // namespace culm::fit
