// SPDX-License-Identifier: BSD-3-Clause
// Which effects the recordings require: the posterior over models, reported as a verdict.
#pragma once

#include "diagnose/answers.hpp"
#include "diagnose/detection_limits.hpp"
#include "diagnose/experiment/next_experiment.hpp"
#include "diagnose/ladder.hpp"
#include "diagnose/missing_force/missing_force.hpp"

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace culm::diagnose {

enum class Conclusion {
    /// The published chain belongs to the smallest set of explanations that holds 95 % of the
    /// probability; of several stems it has 95 %.
    Adequate,
    Effect, ///< one set of families holds 95 %
    Tie,    ///< several sets of families are needed
    Unknown ///< the best model's residual has structure too large to ignore
};
/// "adequate", "effect", "tie", "unknown".
[[nodiscard]] std::string_view to_string(Conclusion conclusion);

/// A model on the way from the published chain to the answer.
struct SearchedModel {
    fit::Fit fit;
    SetVerdict verdict;
    double log_evidence = 0.0; ///< over that of the published chain
};

struct Diagnosis {
    Conclusion conclusion = Conclusion::Unknown;
    std::string reason;                ///< one sentence
    std::vector<std::string> effects;  ///< of the likeliest explanation; empty if adequate
    double probability = 0.0;          ///< of the explanation, or of the published chain
    std::vector<NamedFamily> families; ///< that all explanations which hold 95 % share
    std::vector<FamilyExplanation> alternatives; ///< these explanations, likeliest first
    std::vector<EffectAnswer> answers;           ///< effects with their probability and size
    std::vector<StemAnswer> stems;
    Population before; ///< of several stems
    Population after;
    Posterior posterior;
    /// With its log evidence over that of the best model.
    std::optional<UnvisitedModel> largest_unvisited;
    std::vector<DetectionLimit> detection_limits; ///< what the best model does not contain
    Policy policy;                                ///< by which the answer was found
    int batches = 0;                              ///< of lanes that were run for the fits of models
    bool is_complete = true; ///< false: the search ended at the largest number of models

    // For one stem only.
    std::vector<SearchedModel> ladder;        ///< the baseline first, the answer last
    double explained = 0.0;                   ///< share of the baseline's χ² above the noise
    double unexplained = 0.0;                 ///< rms of the residual above the noise, m
    double unexplained_share = 0.0;           ///< of the rms of the swing
    std::vector<Experiment> next_experiments; ///< the most informative first
    std::optional<MissingForce> missing_force;
    fit::Fit baseline;                   ///< the published chain
    fit::Fit final_fit;                  ///< of the last model of the ladder
    std::vector<Comparison> comparisons; ///< (recordings) of final_fit
};

/// The verdict on the models of a search, without detection limits, next experiments and missing
/// force.
[[nodiscard]] Diagnosis decide(const SearchResult& search);

/// Diagnoses one stem, or several together (specimens_of()). Default candidates:
/// candidate_effects(); those that fail are listed. Throws core::InputError if the only stem shows
/// no motion, core::NumericalError if no published chain can be fitted, run::Abandoned if the
/// heartbeat says so.
[[nodiscard]] Diagnosis diagnose(std::span<const Specimen> specimens,
                                 DiagnosisOptions options = {});

} // namespace culm::diagnose
