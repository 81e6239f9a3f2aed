// SPDX-License-Identifier: BSD-3-Clause
// Which effects act in a laboratory: on the rig, with one value for all stems, or in some stems,
// each with its own value.
#pragma once

#include "diagnose/laboratory/laboratory_fit.hpp"

#include <map>
#include <span>
#include <string>
#include <vector>

namespace culm::diagnose {

/// A model whose log evidence was only predicted, about a fitted model without its last effects.
struct LaboratoryPrediction {
    std::size_t base = 0;               ///< of the visited models
    std::vector<RigEffect> rig_effects; ///< added, with the values of the linear estimate
    fit::SelectedEffects own;           ///< added: at most one effect, in `stems`
    std::vector<std::size_t> stems;
    double gain = 0.0;         ///< predicted, over the base
    double log_evidence = 0.0; ///< expected at the end of the search
};

/// Those of the predicted model.
[[nodiscard]] EffectOwners owners_of(const LaboratoryPrediction& prediction,
                                     const LaboratoryModel& base);

struct LaboratorySearchResult {
    std::vector<ObservedStem> stems;
    std::vector<LaboratoryModel> visited; ///< the published chain (with what is known) first
    std::size_t best = 0;
    std::vector<LaboratoryPrediction> unvisited; ///< the largest log evidence first
    std::vector<StemSurvey> surveys;             ///< (stems) about the best
    std::vector<NoiseScale> noise;               ///< (stems) about the best
    std::map<std::string, SharedPrior> priors;   ///< of shared numbers
};

/// The evidence of a laboratory is the sum over its stems, with the shared numbers counted once
/// (docs/laboratory.md). The search is that of search_models(), with two kinds of
/// additions: effects of a rig, and an effect in those stems that need it. `options.known` act in
/// every stem; those of the rig are shared. Stems whose chain cannot be fitted are left out.
///
/// The result does not depend on the number of ranks. Throws core::NumericalError if no stem can be
/// fitted, run::Abandoned if the heartbeat says so.
[[nodiscard]] LaboratorySearchResult search_laboratory(std::span<const Specimen> specimens,
                                                       const DiagnosisOptions& options);

/// Probability that each stem has an effect, from the change of its log evidence if it has: the
/// mean-field solution where the share of stems with the effect is unknown (Stephan et al. 2009,
/// NeuroImage 46:1004-1017).
[[nodiscard]] std::vector<double> presence_of(std::span<const double> gains);

} // namespace culm::diagnose
