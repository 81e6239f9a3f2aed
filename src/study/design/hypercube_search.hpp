// SPDX-License-Identifier: BSD-3-Clause
// Latin hypercubes made more even by exchanges.
#pragma once

#include "study/design/sampling.hpp"

#include <cstdint>
#include <vector>

namespace culm::study {

/// Measure of the evenness of a Latin hypercube.
enum class HypercubeCriterion {
    None,    ///< as the strata were shuffled
    Maximin, ///< large distances between neighbours: φ_p of Morris & Mitchell (1995), p = 16
    CentredDiscrepancy ///< small centred L2 discrepancy of Hickernell (1998)
};

/// A search with more points takes minutes and improves little.
inline constexpr std::int64_t most_searched_points = 10'000;

/// Strata of a Latin hypercube: (coordinates, points), each coordinate a permutation of
/// 0 … points − 1.
using Strata = std::vector<std::vector<std::int64_t>>;

/// Exchanges two random strata of one coordinate at a time and keeps an exchange unless it worsens
/// the criterion by more than a threshold that falls to zero halfway (threshold accepting, Winker &
/// Fang 1997). Coordinates whose `is_movable` is false do not change. The result depends only on
/// the arguments; `key` selects the exchanges.
void spread_evenly(Strata& strata, const std::vector<bool>& is_movable,
                   HypercubeCriterion criterion, const SampleKey& key);

} // namespace culm::study
