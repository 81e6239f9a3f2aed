// SPDX-License-Identifier: BSD-3-Clause
// What the readings show of the first modes before a chain is fitted: where its fit begins.
#pragma once

#include "fit/chain/stem_model.hpp"
#include "reduce/backbone/damped_modes.hpp"
#include "reduce/ring_down/ring_down_fit.hpp"

#include <complex>
#include <cstddef>

namespace culm::fit {

/// Eq. 1 at one height.
struct RowRingDown {
    std::size_t row = 0;
    reduce::RingDownFit fit;
};

/// Eq. 1 at the height of the largest swing where it can be fitted, or of the sensor that it
/// explains best. Throws core::NumericalError (FitFailed) if it can be fitted nowhere.
[[nodiscard]] RowRingDown measured_ring_down(const measure::Measurement& measurement);

/// Frame period, s, from the camera's rate if known, else the median difference of the times.
[[nodiscard]] double frame_period(const measure::Measurement& measurement);

/// The readings of all rows, weighted by their noise or their size.
[[nodiscard]] reduce::HeightHistories height_histories(const measure::Measurement& measurement);

/// Amplitude (m) and phase of the tip's vibration that a ring-down of a row implies.
[[nodiscard]] std::complex<double> tip_motion(const measure::Measurement& measurement,
                                              const RowRingDown& found);

/// Median of the tip deflections (m) that the readings near the release imply for the shape of a
/// cantilever under a force at its tip.
[[nodiscard]] double released_deflection(const measure::Measurement& measurement);

/// Sets a release a quarter to three quarters of a period before the record, where it was not
/// recorded, such that the first mode has its recorded amplitude and phase.
void release_before(const measure::Measurement& measurement, const RowRingDown& found,
                    StemModel& model);

} // namespace culm::fit
