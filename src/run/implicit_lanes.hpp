// SPDX-License-Identifier: BSD-3-Clause
// Implicit cases side by side in SIMD lanes, one stem per lane, each with its own steps.
#pragma once

#include "run/simulate.hpp"

#include <span>
#include <vector>

namespace culm::run {

/// As many cases as T has lanes, or fewer (see can_share_lanes); T is double or core::Lanes.
/// Every lane's result is bit for bit what it is beside any other neighbours.
template <class T>
[[nodiscard]] std::vector<CaseOutcome> simulate_implicit_lanes(std::span<const CaseSpec> specs,
                                                               const Heartbeat& heartbeat);

/// One case by SUNDIALS.
[[nodiscard]] CaseOutcome simulate_with_sundials(const CaseSpec& spec, const Heartbeat& heartbeat,
                                                 integrate::SundialsIntegrators& integrators);

/// As many implicit cases as there are lanes, or fewer, of equal duration: all take the steps of
/// the first one, so that their differences are smooth in what distinguishes them.
[[nodiscard]] std::vector<CaseOutcome> simulate_on_common_steps(std::span<const CaseSpec> specs,
                                                                const Heartbeat& heartbeat);

} // namespace culm::run
