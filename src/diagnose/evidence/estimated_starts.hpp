// SPDX-License-Identifier: BSD-3-Clause
// Where the fit of a model with more effects begins: at the linear estimate about the smaller one.
#pragma once

#include "diagnose/evidence/effect_view.hpp"

#include <span>
#include <vector>

namespace culm::diagnose {

/// A fitted stem, linearised.
struct LinearisedStem {
    const fit::Fit& fit; ///< with its parts
    std::span<const fit::ObservedRecording> recordings;
    const SharedColumns& columns;
    const fit::SelectedEffects& candidates;
    const EffectView& view; ///< of the candidates
};

/// Sets the numbers of the candidate in a model that has it. `columns`: of the candidate; of
/// several recordings with own sizes, the model is that of number `recording`.
void place_effect(const physics::SelectedEffect& candidate, const EffectColumns& columns,
                  const PlacedEffect& effect, std::size_t recording, fit::StemModel& model);

/// Starts of a model with the candidates `chosen`, as fit::fit_near() takes them: the linear
/// estimate of each point of `gain`, a quarter of the way to the likeliest one, and last the model
/// without the effects. Y and β keep the first mode of the straight way (fit::in_valley()).
[[nodiscard]] std::vector<fit::StartModels>
starts_to_estimate(const LinearisedStem& base, const std::vector<std::size_t>& chosen,
                   const PredictedGain& gain);

} // namespace culm::diagnose
