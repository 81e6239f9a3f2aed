// SPDX-License-Identifier: BSD-3-Clause
// The readings that a model predicts, and their derivatives by its free parameters.
#pragma once

#include "fit/chain/stem_model.hpp"
#include "run/simulate.hpp"

#include <span>
#include <vector>

namespace culm::fit {

/// Readings at `times` (s, ascending, 0 about the release) and the case's heights. The chain is
/// sampled in time, and a reading is a cubic through four samples (measure::time_stencil), which
/// also gives the derivative by the release time. Before the release, the readings are those of the
/// held stem, which moves with its support. A superposed model (superposition.hpp) is computed by
/// its planar models; its Y must be free. Throws core::NumericalError if the case cannot be
/// computed, run::Abandoned if the heartbeat says so.
[[nodiscard]] ChainPrediction predict_readings(const StemModel& model,
                                               std::span<const double> times,
                                               const run::Heartbeat& heartbeat = {});

/// Readings of several models of one recording at the same times, without derivatives. The models
/// differ only in their numbers, so they share SIMD lanes, and all take the steps of the first one.
/// Their differences are then smooth in these numbers. Throws as predict_readings().
[[nodiscard]] std::vector<ChainPrediction> predict_together(std::span<const StemModel> models,
                                                            std::span<const double> times,
                                                            const run::Heartbeat& heartbeat = {});

} // namespace culm::fit
