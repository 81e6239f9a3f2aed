// SPDX-License-Identifier: BSD-3-Clause
// Cases side by side in SIMD lanes, one stem per lane; and one case by SUNDIALS.
#pragma once

#include "integrate/sundials/integrator.hpp"
#include "run/case_result.hpp"
#include "run/case_spec.hpp"

#include <span>
#include <vector>

namespace culm::run {

/// As many cases as T has lanes, or fewer (see can_share_lanes); T is double or core::Lanes.
/// Every lane's result is bit for bit what it is beside any other neighbours.
template <class T>
[[nodiscard]] std::vector<CaseOutcome>
simulate_implicit_lanes(std::span<const CaseSpec> specs, const integrate::Heartbeat& heartbeat);

/// One case by SUNDIALS.
[[nodiscard]] CaseOutcome simulate_with_sundials(const CaseSpec& spec,
                                                 const integrate::Heartbeat& heartbeat,
                                                 integrate::SundialsIntegrators& integrators);

/// As many implicit cases as there are lanes, or fewer, of equal duration: all take the steps of
/// the first one, so that their differences are smooth in what distinguishes them.
[[nodiscard]] std::vector<CaseOutcome>
simulate_on_common_steps(std::span<const CaseSpec> specs, const integrate::Heartbeat& heartbeat);

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
[[nodiscard]] std::vector<CaseOutcome>
simulate_explicit_lanes(std::span<const CaseSpec> specs, const integrate::Heartbeat& heartbeat);

} // namespace culm::run
