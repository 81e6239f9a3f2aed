// SPDX-License-Identifier: BSD-3-Clause
// Modes 2 and 3 of a motion whose release was not recorded.
//
// A hand, a string or an earlier blow gives the higher modes any amplitude and phase, a sensor of
// acceleration shows them forty and three hundred times larger than a deflection does, and in a
// light strip they ring for hundreds of cycles, over which no chain predicts their phase. The chain
// is released in its first mode alone, and its linear modes k = 2, 3 are superposed on its
// readings:
//
//     y_j(t) = φ_jk Re[B s(t)^n e^(∫s dt)],   B = a − i (v − Re s(0) a)/Im s(0),
//     s(t) = −d e^μ (1 − ρ + ρ e^(−γt)) + i ω e^λ (1 − σ e^(−γt)),
//
// with ω of the chain's mode, its reading φ_jk per deflection of the tip at the height j, the order
// n of the reading's time derivative, the decay rates d of the mode in the first cycles and γ of
// mode 1 as they were recorded, and six numbers for each recording and mode: the deflection a and
// the speed v at time 0, and λ, σ, μ and ρ, which are known to be zero within
//
//     u(λ) = (2/π) η ln(f_k/f₁),  at least the chain's own error (second_mode.hpp),
//     u(σ) = 0.01,  u(μ) = ln 2,  u(ρ) = 0.5, 0 ≤ ρ ≤ 1.
//
// The frequency remains a reading of the chain; the loss is none, because air and material damp
// each mode by another law. Frequency and loss change with the amplitude of the swing.
//
// Traps. A loss in proportion to that of the chain bends the valley of the fit: β and e^μ then
// compensate each other. e^(−γt) is the amplitude of mode 1 only if that decays exponentially.
#pragma once

#include "fit/chain/stem_model.hpp"

#include <span>

namespace culm::fit {

/// Adds the numbers of the modes that the recording resolves, with starts from its first cycles,
/// and releases the chain in its first mode. `loss_factor`: of mode 1, as recorded.
void add_higher_modes(const measure::Measurement& measurement, double loss_factor,
                      StemModel& model);

/// Standard uncertainty of ln f_k in a chain, u(λ) above.
[[nodiscard]] double log_frequency_uncertainty(double loss_factor, double frequency_ratio,
                                               int spheres);

/// Adds the modes to the readings of a chain that was released in its first mode, and the
/// derivatives by all free parameters that change them.
void superpose_higher_modes(const StemModel& model, std::span<const double> times,
                            ChainPrediction& prediction);

} // namespace culm::fit
