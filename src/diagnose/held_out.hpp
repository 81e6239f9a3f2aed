// SPDX-License-Identifier: BSD-3-Clause
// How well a model predicts readings that it was not fitted to.
#pragma once

#include "core/item_map.hpp"
#include "diagnose/policy.hpp"
#include "fit/fit_model.hpp"
#include "fit/solve/fit.hpp"

#include <span>
#include <string>
#include <vector>

namespace culm::diagnose {

/// Readings that a fit did not see.
struct HeldOutPart {
    double rms = 0.0;        ///< m
    double over_noise = 0.0; ///< root mean square of residual over noise
    std::size_t readings = 0;
    std::vector<double> blocks; ///< mean square of residual over noise in blocks of time
    std::string failure;        ///< why there is no number; empty if there is
};

template <class Wire>
void fields(Wire& wire, HeldOutPart& part) {
    wire(part.rms, part.over_noise, part.readings, part.blocks, part.failure);
}

struct HeldOut {
    HeldOutPart last_third; ///< of the time, predicted by a fit to the first two thirds
    HeldOutPart one_height; ///< predicted by a fit to the other heights
};

/// The row that is left out: of those in the upper half of the stem, the one where a baseline fails
/// most.
[[nodiscard]] std::size_t row_to_leave_out(const fit::RecordingFit& baseline);

/// What is held out, and by what its residuals are weighed: the same for models that are compared.
struct HoldOut {
    std::size_t row = 0;
    std::vector<double> noise; ///< (rows), m
    double block_length = 0.0; ///< of the blocks of time, s
};

/// By the noise of `fit`, in blocks of three periods of its beam.
[[nodiscard]] HoldOut hold_out_of(std::size_t row, const fit::RecordingFit& fit,
                                  const Policy& policy = {});

/// Refits the candidate from its own values twice, without the last third and without the row. Of
/// a model in which nothing moves the residuals are what it predicts.
[[nodiscard]] HeldOut predict_held_out(const fit::Fit& candidate, const HoldOut& hold_out,
                                       const fit::ObservedRecording& measurement,
                                       const fit::FitOptions& options = {});

enum class HeldOutReadings { LastThird, OneHeight };

/// One of the two, of one model of several recordings, `parts` and `hold_out` one for each: what
/// they share stays shared, and the held-out readings of all count together.
[[nodiscard]] HeldOutPart predict_held_out(HeldOutReadings which,
                                           std::span<const fit::RecordingFit> parts,
                                           std::span<const HoldOut> hold_out,
                                           std::span<const fit::ObservedRecording> recordings,
                                           const fit::BelongsToRecording& belongs_to_recording,
                                           const fit::FitOptions& options = {});

/// Both models of a step refitted without the last third of the time and without one height, in
/// every recording, on the coarse image of each.
struct HeldOutPair {
    HeldOut larger;
    HeldOut smaller;
};
[[nodiscard]] HeldOutPair hold_out_from_both(const fit::Fit& smaller, const fit::Fit& larger,
                                             std::span<const fit::ObservedRecording> recordings,
                                             const fit::FitOptions& options,
                                             const core::ItemMap& map);

/// Is the mean of the block-wise differences larger − smaller below 0 by more than 1.96 of its
/// standard errors? With few blocks the mean square has to fall clearly.
[[nodiscard]] bool predicts_better(const HeldOutPart& larger, const HeldOutPart& smaller,
                                   const Policy& policy = {});

/// By blocks of time (predicts_better), or as a whole: what an effect does in the first
/// milliseconds only is in one block of many.
[[nodiscard]] bool is_predicted_better(const HeldOutPart& larger, const HeldOutPart& smaller,
                                       const Policy& policy = {});

} // namespace culm::diagnose
