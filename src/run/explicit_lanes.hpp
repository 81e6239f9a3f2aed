// SPDX-License-Identifier: BSD-3-Clause
// Explicit cases side by side in SIMD lanes, one stem per lane.
#pragma once

#include "run/simulate.hpp"

#include <span>
#include <vector>

namespace culm::run {

/// Steps between two looks at the heartbeat: about a millisecond for 56 spheres.
inline constexpr std::int64_t steps_per_beat = 1000;
/// A released stem only loses energy. One that has gained this share of what it was released with
/// is unstable: the step is too large. The deflection alone is no criterion, because an unstable
/// axial mode saturates in a crumpled chain whose tip looks harmless. Velocity Verlet's own energy
/// error stays far below at any stable step.
inline constexpr double unstable_energy_gain = 0.05;

/// At most lanes_per_batch() explicit cases that can share lanes; empty lanes repeat the first
/// case, so that every lane goes through the same arithmetic whatever its neighbours are.
/// A lane that diverges is reported for its case alone.
[[nodiscard]] std::vector<CaseOutcome> simulate_explicit_lanes(std::span<const CaseSpec> specs,
                                                               const Heartbeat& heartbeat);

} // namespace culm::run
