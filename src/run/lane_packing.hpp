// SPDX-License-Identifier: BSD-3-Clause
// Cases side by side in SIMD lanes: their parameters, and the states at their release.
#pragma once

#include "core/lanes.hpp"
#include "physics/chain_model.hpp"
#include "physics/stem.hpp"
#include "run/case_result.hpp"
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

} // namespace culm::run
