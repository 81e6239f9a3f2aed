// SPDX-License-Identifier: BSD-3-Clause
// Cases side by side in SIMD lanes, one stem per lane; and one case by SUNDIALS.
#pragma once

#include "core/lanes.hpp"
#include "integrate/sundials/integrator.hpp"
#include "physics/chain_model.hpp"
#include "run/case_spec.hpp"

#include <optional>
#include <span>
#include <vector>

namespace culm::run {

/// The specification in lane `lane`; lanes beyond the cases repeat the first.
[[nodiscard]] inline const CaseSpec& in_lane(std::span<const CaseSpec> specs, std::size_t lane) {
    return specs[lane < specs.size() ? lane : 0];
}

/// One stem in every lane. T is double (of the first case) or Lanes.
template <class T>
[[nodiscard]] physics::StemParameters<T> packed_stems(std::span<const CaseSpec> specs);

/// The equilibria of the lanes at the release, in the chain's layout. A case without one has a
/// failure, and its lane continues with the straight chain at rest.
template <class T>
struct ReleasedState {
    physics::ChainModel<T> model; ///< of the chains, with the data that only the release determines
    std::vector<T> state;
    std::vector<std::optional<CaseFailure>> failures; ///< (cases)
};
using ReleasedLanes = ReleasedState<core::Lanes>;

template <int Dim, class T = core::Lanes>
[[nodiscard]] ReleasedState<T> released_lanes(std::span<const CaseSpec> specs);

/// At most one case per lane of T (see can_share_lanes); T is double or core::Lanes.
/// Every lane's result is bit for bit the same for any neighbours. With `integrators`: one case, by
/// SUNDIALS.
template <class T>
[[nodiscard]] std::vector<CaseOutcome>
simulate_implicit_lanes(std::span<const CaseSpec> specs, const integrate::Heartbeat& heartbeat,
                        integrate::SundialsIntegrators* integrators = nullptr);

/// At most one implicit case per lane, all of equal duration. All take the steps of the first one,
/// so that their differences are smooth functions of their parameters.
[[nodiscard]] std::vector<CaseOutcome>
simulate_on_common_steps(std::span<const CaseSpec> specs, const integrate::Heartbeat& heartbeat);

/// Steps between two calls of the heartbeat: about a millisecond for 56 spheres.
inline constexpr std::int64_t steps_per_beat = 1000;
/// A released stem only loses energy. If it gains this share of its initial energy, the step is too
/// large and the motion unstable. The deflection alone is not a criterion, because an unstable
/// axial mode saturates in a crumpled chain whose tip moves little. The energy error of velocity
/// Verlet is far smaller at any stable step.
inline constexpr double unstable_energy_gain = 0.05;

/// At most lanes_per_batch() explicit cases that can share lanes; empty lanes repeat the first
/// case, so that the arithmetic of every lane does not depend on its neighbours.
/// A lane that diverges fails its own case only.
[[nodiscard]] std::vector<CaseOutcome>
simulate_explicit_lanes(std::span<const CaseSpec> specs, const integrate::Heartbeat& heartbeat);

} // namespace culm::run
