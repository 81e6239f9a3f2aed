// SPDX-License-Identifier: BSD-3-Clause
// Explicit cases side by side in SIMD lanes, one stem per lane.
#pragma once

#include "run/simulate.hpp"

#include <span>
#include <vector>

namespace culm::run {

/// At most lanes_per_batch() explicit cases that can share lanes; empty lanes repeat the first
/// case, so that every lane goes through the same arithmetic whatever its neighbours are.
/// A lane that diverges is reported for its case alone.
[[nodiscard]] std::vector<CaseOutcome> simulate_explicit_lanes(std::span<const CaseSpec> specs,
                                                               const Heartbeat& heartbeat);

} // namespace culm::run
