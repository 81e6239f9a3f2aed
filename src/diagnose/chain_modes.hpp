// SPDX-License-Identifier: BSD-3-Clause
// Frequencies and decay of a stem's lowest modes, its effects included.
#pragma once

#include "integrate/linearised.hpp"
#include "run/case_spec.hpp"

#include <cstddef>
#include <vector>

namespace culm::diagnose {

/// The slowest transverse modes of the case in its plane, linearised about the straight line:
/// effects count as far as they are linear there, those that leave the plane and quadratic drag
/// not at all. Maxwell branches stiffen the first mode as they do at its frequency, and all modes
/// alike. At most `count`; none if the chain does not vibrate.
[[nodiscard]] std::vector<integrate::VibrationMode> chain_modes(const run::CaseSpec& spec,
                                                                std::size_t count);

} // namespace culm::diagnose
