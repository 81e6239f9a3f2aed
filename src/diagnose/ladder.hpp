// SPDX-License-Identifier: BSD-3-Clause
// Models of growing size fitted to one measurement, and whether each step is a gain.
#pragma once

#include "diagnose/comparison.hpp"

#include <optional>
#include <string>
#include <vector>

namespace culm::diagnose {

/// One model in the ladder. Changes and the gain are relative to the model below it with the
/// largest log evidence.
struct LadderModel {
    fit::Fit stated; ///< with every input as stated: its numbers and residuals are shown
    fit::Fit fit;    ///< with the error terms of the readings: it is tested and compared
    std::size_t compared_with = 0;  ///< index of that model in the ladder
    std::vector<std::string> added; ///< effects that it does not have
    double log_evidence = 0.0;      ///< over that of the baseline
    double log_evidence_gain = 0.0; ///< against `compared_with`
    double modulus_change = 0.0;    ///< of Y, relative
    double damping_change = 0.0;    ///< of β, relative
    bool is_gain = false;
    std::string why; ///< one sentence: why it is a gain, or why not
};

struct Ladder {
    std::vector<LadderModel> models; ///< the baseline first
    std::vector<Comparison>
        comparisons; ///< of every model that has a fit, in order; by `comparison`
    std::vector<std::optional<std::size_t>> comparison; ///< (models): index in `comparisons`
};

/// Throws core::InputError if the readings are consistent with noise alone.
///
/// Fits the baseline and every set of `effect_sets`. Each set contains the previous one, and its
/// fit starts from the largest fitted model that it contains.
///
/// A model is a gain if its probability, relative to the model below it with the largest log
/// evidence, is at least Policy::held_probability, both with the noise of the best model
/// (log_evidence.hpp). A model without motion, or with an effect that ended absent, is not a gain.
[[nodiscard]] Ladder climb(const measure::Measurement& measurement,
                           const std::vector<fit::SelectedEffects>& effect_sets,
                           const fit::FitOptions& options = {}, const Policy& policy = {});

} // namespace culm::diagnose
