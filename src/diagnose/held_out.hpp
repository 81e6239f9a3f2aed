// SPDX-License-Identifier: BSD-3-Clause
// How well a model predicts readings that it was not fitted to. For information only.
#pragma once

#include "fit/fit_model.hpp"
#include "fit/solve/fit.hpp"

#include <string>
#include <vector>

namespace culm::diagnose {

/// Readings that a fit did not see.
struct HeldOutPart {
    double rms = 0.0;        ///< m
    double over_noise = 0.0; ///< root mean square of residual over noise
    std::size_t readings = 0;
    std::string failure; ///< why there is no number; empty if there is
};

struct HeldOut {
    HeldOutPart last_third; ///< of the time, predicted by a fit to the first two thirds
    HeldOutPart one_height; ///< predicted by a fit to the other heights
};

/// The row that is left out: the one in the upper half of the stem at which the baseline fits
/// worst.
[[nodiscard]] std::size_t row_to_leave_out(const fit::RecordingFit& baseline);

/// The held-out readings and their noise, common to all models that are compared.
struct HoldOut {
    std::size_t row = 0;
    std::vector<double> noise; ///< (rows), m
};

/// Refits the candidate, a fit to this recording alone, twice from its own values: without the last
/// third and without the row. If nothing moves in the model, its own residuals are used.
[[nodiscard]] HeldOut predict_held_out(const fit::Fit& candidate, const HoldOut& hold_out,
                                       const fit::ObservedRecording& measurement,
                                       const fit::FitOptions& options = {});

} // namespace culm::diagnose
