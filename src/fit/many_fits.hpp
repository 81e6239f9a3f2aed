// SPDX-License-Identifier: BSD-3-Clause
// Several models fitted beside one that they contain, over the ranks and first on a coarse chain.
#pragma once

#include "core/item_map.hpp"
#include "fit/fit_model.hpp"
#include "fit/fit_numbers.hpp"

#include <limits>
#include <span>
#include <vector>

namespace culm::fit {

/// Which fits are followed to their end.
struct FitGoal {
    double chi_squared = std::numeric_limits<double>::infinity(); ///< those that come below it
    bool is_of_best = false; ///< those that come near it, or near the best if that is below it
};

/// Fits each model as fit_model() would: some steps from each of its starts and on to the end from
/// the best on the CoarseImage of `smaller`, then the rest of the way with the chain that was asked
/// for. Fits that slow down and miss the goal, or end above it on the coarse chain, are told of by
/// where they were then, with Fit::out_of_reach. Where the noise is not known all are
/// followed. The same on every rank.
[[nodiscard]] std::vector<Fit> fit_candidates(const std::vector<SelectedEffects>& models,
                                              const Fit& smaller,
                                              std::span<const ObservedRecording> recordings,
                                              const FitOptions& options, const core::ItemMap& map,
                                              const FitGoal& goal);

/// Of a run with these effects, against one of the published chain: spatial chains take six times
/// as long.
[[nodiscard]] double relative_cost(const SelectedEffects& effects);

} // namespace culm::fit
