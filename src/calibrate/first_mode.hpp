// SPDX-License-Identifier: BSD-3-Clause
// Frequency and decay of a stem's first mode at small amplitudes.
#pragma once

#include "integrate/linearised.hpp"
#include "run/case_spec.hpp"

namespace culm::calibrate {

/// Natural frequency and damping ratio of a mode.
struct ModeOfChain {
    double natural_frequency = 0.0; ///< undamped, Hz
    double damping_ratio = 0.0;     ///< ζ
    double frequency = 0.0;         ///< damped, √(1 − ζ²) of the natural one, Hz: b2 of Eq. 1
    double decay_per_cycle = 0.0;   ///< −2πζ/√(1 − ζ²): b1 of Eq. 1 in normalised time
};

/// The first mode of the case's chain, linearised about the straight line: known masses count,
/// effects do not. Throws core::NumericalError if it does not vibrate.
[[nodiscard]] ModeOfChain first_mode(const run::CaseSpec& spec);

/// The lowest natural frequency of the case's chain in its plane, undamped and linearised about the
/// straight line, Hz: effects count as far as they are linear there, Maxwell branches as relaxed.
/// NaN if the chain does not stand.
[[nodiscard]] double lowest_frequency_with_effects(const run::CaseSpec& spec);

/// beam_frequency() with what known masses on the stem make of it, Hz: by the share by which they
/// change the chain's. Throws as first_mode() if there are any.
[[nodiscard]] double natural_frequency(const run::CaseSpec& spec);

} // namespace culm::calibrate
