// SPDX-License-Identifier: BSD-3-Clause
// Values of a model's parameters at which its first mode has a wanted frequency.
#pragma once

#include "calibrate/free_parameter.hpp"

#include <functional>

namespace culm::diagnose {

/// Of chain_modes, Hz; NaN if the chain does not vibrate.
[[nodiscard]] double first_frequency(const run::CaseSpec& spec);

/// Y (Pa) at which the case's first mode has this frequency (Hz).
[[nodiscard]] double matching_modulus(run::CaseSpec spec, double frequency);

/// Sets `size` in `spec` to where `excess` vanishes, sought from where its effect is absent in
/// steps that double, both ways within its bounds; where it vanishes nowhere, to where it is
/// smallest.
void match(const calibrate::FreeParameter& size, run::CaseSpec& spec,
           const std::function<double(const run::CaseSpec&)>& excess);

} // namespace culm::diagnose
