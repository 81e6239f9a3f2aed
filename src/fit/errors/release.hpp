// SPDX-License-Identifier: BSD-3-Clause
// A release by hand: each resolved mode but the first starts with its own amplitude and velocity.
// If the release was not recorded, they are parameters (fit/chain/higher_modes.hpp).
#pragma once

#include "fit/solve/fit_result.hpp"

#include <vector>

namespace culm::fit {

/// About a fit of one recording whose release was recorded; empty unless an exact release shows
/// departures as large as those in the first two periods in at most one case of a thousand.
[[nodiscard]] std::vector<ErrorTerm> release_terms(const Fit& fit,
                                                   const ObservedRecording& recording);

} // namespace culm::fit
