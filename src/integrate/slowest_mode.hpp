// SPDX-License-Identifier: BSD-3-Clause
// The slowest vibration mode alone, for those who ask for it often.
#pragma once

#include "integrate/linearised.hpp"

#include <optional>

namespace culm::integrate {

/// The first of vibration_modes(), at a small part of its cost: Newton's method on
/// (λ²M + λC + K) u = 0 (inverse iteration: Ruhe 1973, SIAM J. Numer. Anal. 10:674) from the mode
/// without damping. Where that leads to no vibration near it, as with damping that is nearly
/// aperiodic, all modes are computed after all. Empty if none vibrates.
[[nodiscard]] std::optional<VibrationMode> slowest_mode(const LinearisedChain& chain);

} // namespace culm::integrate
