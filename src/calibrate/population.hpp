// SPDX-License-Identifier: BSD-3-Clause
// What a set of calibrated stems says of all stems.
#pragma once

#include "reduce/population_statistics.hpp"

#include <span>

namespace culm::calibrate {

/// "90 % of the stems lie in lower … upper", with what 95 % of resampled populations give for
/// either end.
struct CentralRange {
    reduce::SampleSummary sample;
    reduce::Bounds range;          ///< the 5 % and 95 % quantiles
    reduce::Bounds lower_interval; ///< of the lower end, 95 %
    reduce::Bounds upper_interval;
};

/// Quantiles with percentile bootstrap intervals (Efron 1979): `resamples` populations of the same
/// size drawn with replacement by a generator of fixed seed, so that the answer is always the same.
/// The ends of few stems are little more than the extreme ones, and the intervals say so.
[[nodiscard]] CentralRange central_range(std::span<const double> values, int resamples = 4000);

} // namespace culm::calibrate
