// SPDX-License-Identifier: BSD-3-Clause
// What the search found, turned into an answer.
#pragma once

#include "diagnose/diagnosis.hpp"

#include <map>
#include <span>
#include <string>
#include <vector>

namespace culm::diagnose {

/// An effect of the answer and the sets that do as well with another in its place.
struct Rivals {
    physics::SelectedEffect effect;
    std::vector<fit::Fit> models;
    std::vector<double> delta_bic; ///< of each against the answer
};

/// Every candidate beside the model from which the search set out.
struct FirstStep {
    std::vector<fit::Fit> models;
    std::vector<EffectScore> scores;
};

/// Why the search ends with its conclusion.
enum class ConclusionReason {
    ResidualsAreNoise,   ///< of the published chain
    FailsAsNoiseMay,     ///< its tests object, but no more than noise may make them
    RecordingCannotTell, ///< too short, or hardly any motion
    NothingExplains,     ///< no candidate is accepted
    StructureIsLeft,     ///< the effects explain too little to be named beside it
    EffectHasFallen,     ///< one of them stands at a bound or is absent now that others have joined
    ExplainsAll,
    ExplainsNearlyAll
};

struct Found {
    std::span<const fit::ObservedRecording> recordings;
    const DiagnosisOptions& options;
    const fit::SelectedEffects& candidates;
    const fit::Fit& model; ///< that was reached
    const fit::Fit& start; ///< from which the search set out
    const FirstStep& first;
    const std::vector<Rivals>& rivals;
    const std::map<std::string, std::string>& refused; ///< effects that predict no better, and why
    bool is_one_law = false; ///< the rivals do together what one law between them would
};

/// Adds the conclusion and its reason, ties, ranking, the false-positive rate, the suggested
/// experiments and, for an unknown effect, the missing force. `result` has the ladder, the fits and
/// the scores of the final model.
void complete(const Found& found, Diagnosis& result);

} // namespace culm::diagnose
