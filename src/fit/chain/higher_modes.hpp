// SPDX-License-Identifier: BSD-3-Clause
// Modes 2 and 3 of a motion whose release was not recorded.
//
// A hand, a string or an earlier blow gives the higher modes any amplitude and phase, a sensor of
// acceleration shows them forty and three hundred times larger than a deflection does, and in a
// light strip they ring for hundreds of cycles, over which no chain predicts their phase. The chain
// is released in its first mode alone, and its linear modes k = 2, 3 are superposed on its
// readings:
//
//     y_j(t) = φ_jk Re[B s^n e^(st)],   s = −δ e^μ + i ω e^λ,   B = a − i (v + δ e^μ a)/(ω e^λ),
//
// with δ and ω of the chain's mode, its reading φ_jk per deflection of the tip at the height j, the
// order n of the reading's time derivative, and four numbers for each recording and mode: the
// deflection a and the speed v at time 0, and λ and μ, which are known to be zero within
//
//     u(λ) = (2/π) η ln(f_k/f₁),  at least the chain's own error, and  u(μ) = ln 2
//
// (second_mode.hpp): the frequency remains a reading of the chain.
//
// Traps. The modes are those of small motions: drag and slip that couple the modes change μ only.
#pragma once

#include "fit/chain/prediction.hpp"
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
