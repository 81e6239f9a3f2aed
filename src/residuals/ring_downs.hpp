// SPDX-License-Identifier: BSD-3-Clause
// Eq. 1 at every height, fitted to the measurement and to the prediction of a fitted chain.
#pragma once

#include "fit/solve/fit.hpp"
#include "measure/folder/measurement.hpp"
#include "reduce/ring_down/stem_ring_downs.hpp"

namespace culm::residuals {

/// The readings at every height, with their noise where it is known.
[[nodiscard]] reduce::StemHistories histories_of(const measure::Measurement& measurement);

struct RingDownsOfBoth {
    reduce::StemRingDowns measured;
    reduce::StemRingDowns modelled; ///< at the same times and heights
};

/// Eq. 1 with a free phase, fitted in the same way to both, over the time of the fit.
[[nodiscard]] RingDownsOfBoth ring_downs_of_both(const fit::RecordingFit& fit,
                                                 const measure::Measurement& measurement);

} // namespace culm::residuals
