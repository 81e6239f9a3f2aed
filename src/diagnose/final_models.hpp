// SPDX-License-Identifier: BSD-3-Clause
// The models that compete for the answer, with the number of spheres that the user stated.
#pragma once

#include "diagnose/model_search.hpp"

#include <span>

namespace culm::diagnose {

/// A search with the chain of `coarse` whose rivals are fitted again with the chain of `options`:
/// the published chain, the best model, its likeliest part with one effect, and every model within
/// Policy::unvisited_margin of the best. The others keep their numbers and their log evidence
/// relative to the best model. `views` and `stacked` remain those of the search. Returns the search
/// itself if the chains are equal.
[[nodiscard]] SearchResult with_stated_chain(const SearchResult& search,
                                             std::span<const measure::Measurement> recordings,
                                             const DiagnosisOptions& coarse,
                                             const DiagnosisOptions& options);

} // namespace culm::diagnose
