// SPDX-License-Identifier: BSD-3-Clause
// Latin hypercubes made more even by exchanges.
#pragma once

#include "study/design/sampling.hpp"

#include <cstdint>
#include <vector>

namespace culm::study {

/// What an even Latin hypercube is.
enum class HypercubeCriterion {
    None,    ///< as the strata were shuffled
    Maximin, ///< large distances between neighbours: φ_p of Morris & Mitchell (1995), p = 16
    CentredDiscrepancy ///< small centred L2 discrepancy of Hickernell (1998)
};

/// More points would take minutes, and gain little.
inline constexpr std::int64_t most_searched_points = 10'000;

/// Strata of a Latin hypercube: (coordinates, points), each coordinate a permutation of
/// 0 … points − 1.
using Strata = std::vector<std::vector<std::int64_t>>;

/// Exchanges two strata of one coordinate at a time, drawn at random, and keeps what does not make
/// the criterion worse by more than a threshold that falls to zero halfway (threshold accepting,
/// Winker & Fang 1997). Coordinates of which `is_movable` is false stay. The outcome is a function
/// of the arguments; `key` selects the exchanges.
void spread_evenly(Strata& strata, const std::vector<bool>& is_movable,
                   HypercubeCriterion criterion, const SampleKey& key);

} // namespace culm::study
