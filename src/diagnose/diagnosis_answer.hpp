// SPDX-License-Identifier: BSD-3-Clause
// What the search found, turned into an answer.
#pragma once

#include "diagnose/candidate_field.hpp"

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

struct Found {
    std::span<const measure::Measurement> recordings;
    const DiagnosisOptions& options;
    const fit::SelectedEffects& candidates;
    const fit::Fit& model; ///< that was reached
    const fit::Fit& start; ///< from which the search set out
    const std::vector<fit::Fit>& first_step;
    const std::vector<EffectScore>& first_scores;
    const std::vector<Rivals>& rivals;
    const std::map<std::string, std::string>& refused;
    bool is_one_law = false; ///< the rivals do together what one law between them would
};

/// Adds the conclusion and its reason, ties, ranking, the rate of false names, the next experiments
/// and, for an unknown effect, the missing force. `result` has the ladder, the fits and the scores
/// of the final model.
void complete(const Found& found, Diagnosis& result);

} // namespace culm::diagnose
