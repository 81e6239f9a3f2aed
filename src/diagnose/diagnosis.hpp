// SPDX-License-Identifier: BSD-3-Clause
// Which effect recordings call for: stepwise, with exchanges, ties and an honest "unknown".
#pragma once

#include "core/item_map.hpp"
#include "diagnose/adequacy.hpp"
#include "diagnose/experiment/next_experiment.hpp"
#include "diagnose/missing_force/missing_force.hpp"
#include "diagnose/policy.hpp"
#include "diagnose/score/score_test.hpp"
#include "fit/fit_model.hpp"

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace culm::diagnose {

enum class Conclusion {
    Adequate, ///< the published chain explains the recording
    Effect,   ///< these effects, or others of their families, and no others make it do so
    Tie,      ///< effects of several families do, and the recording cannot tell them apart
    Unknown   ///< no candidate does
};
/// "adequate", "effect", "tie", "unknown".
[[nodiscard]] std::string_view to_string(Conclusion conclusion);

/// One candidate beside the model of the first step.
struct RankedEffect {
    std::string effect;
    fit::Fit fit;             ///< without parameters where the score test left no hope
    bool is_refitted = false; ///< false: delta_bic and p_value are the score test's
    double delta_bic = 0.0;   ///< against the model without it: negative is better
    double p_value = 1.0;     ///< of the gain, for as many candidates as there were (Bonferroni)
    std::string obstacle;     ///< why it cannot be named whatever it gains; empty if it can
    std::string signature;
    std::vector<std::string> looks_like; ///< candidates whose trace is the same but for 20 %
};

/// A model on the way to the answer.
struct SearchedModel {
    fit::Fit fit;    ///< with the error terms of the readings: it is tested and compared
    fit::Fit stated; ///< with every input as stated: its numbers and residuals are shown
    Finding finding = Finding::Undecided;
    double p_value = 1.0;         ///< smallest adjusted one of the tests for lack of fit
    std::string tests;            ///< which of them object
    double delta_bic = 0.0;       ///< against the model before
    double held_out = 0.0;        ///< last third of the time, over noise; 0: not computed
    double held_out_before = 0.0; ///< by the model before
};

/// What is missing for certain, as far as the recording tells it.
struct NamedFamily {
    physics::Family family = physics::Family::Own;
    /// One: it is this effect. Several: one of them, or a law between them.
    std::vector<std::string> members;
};

struct TieGroup {
    std::vector<std::string> names; ///< the effect that stands in the answer, then its rivals
    bool is_of_one_family = false;  ///< a recording that cannot tell the law tells its kind
    std::vector<double> delta_bic;  ///< of the rivals against it
    std::string separate_by;
};

/// How often the search would name an effect where only noise is left.
struct FalseNaming {
    double rate = 0.0;
    double upper_bound = 1.0; ///< of its 95 % interval (Clopper and Pearson 1934)
    int draws = 0;
};

struct Diagnosis {
    Conclusion conclusion = Conclusion::Unknown;
    std::string reason;                ///< one sentence
    std::vector<std::string> effects;  ///< in the order found; empty if adequate or unknown
    std::vector<NamedFamily> families; ///< of the effects that have no rival of another family
    std::vector<TieGroup> ties;
    std::vector<RankedEffect> ranking;    ///< best first; failed fits last
    std::vector<SearchedModel> ladder;    ///< the baseline first
    double explained = 0.0;               ///< share of the baseline's χ² above the noise
    std::vector<EffectScore> blind_spots; ///< what the final model does not contain
    FalseNaming false_naming;
    std::vector<Experiment> next_experiments; ///< the most telling first
    std::optional<MissingForce> missing_force;
    fit::Fit baseline;        ///< with the error terms, as SearchedModel::fit
    fit::Fit final_fit;       ///< likewise of the best model that was reached, named or not
    fit::Fit stated_baseline; ///< as SearchedModel::stated
    Policy policy;            ///< by which the answer was found
    int runs = 0;             ///< of the chain with all its derivatives, for the fits of models
};

struct DiagnosisOptions {
    fit::FitOptions candidate;
    fit::SelectedEffects known;      ///< that act for certain; part of every model
    fit::SelectedEffects candidates; ///< empty: candidate_effects()
    std::size_t most_effects = 3;
    Policy policy;
    int null_draws = 200;
    core::ItemMap map;
    std::function<void(const std::string&)> progress; ///< told what is done next; may be empty
};

/// The numbers are those of Policy.
///
/// 1. The published chain is fitted and tested for lack of fit (verdict_on()).
/// 2. Every candidate is scored by a run or a few (score_effect()). Those that promise something
///    are fitted through the chain itself; if none is accepted, all others too, then pairs of the
///    best.
/// 3. The best by bic() joins if it is accepted (judge()), up to three times, until the residuals
///    are noise; beside the published chain also if only the score of a candidate is significant.
///    What belongs to a recording leaves those recordings that do as well without it.
/// 4. Each effect of the answer is exchanged for every other candidate. A set that is better by the
///    tie gap takes its place, one within it is a tie. An effect whose removal costs less goes.
/// 5. Two effects each of which alone explains nearly all of the misfit are a tie of one law. A tie
///    within a family is no tie: the answer is the family. So it is if two laws of its material
///    damping or its air act together: a law between them is missing.
/// 6. If structure is left, effects are named only if they explain nearly all of a glaring misfit.
/// 7. If the noise in motion is another about a model with effects, all of this once more beside
/// it.
///
/// Where nothing moves in the published chain (a stem held straight), what acts for certain and has
/// no number to fit, as gravity, goes before what would have to be assumed.
///
/// The answer does not depend on the ranks or on the order of the candidates. Throws
/// core::NumericalError if the published chain cannot be fitted; candidates that fail are listed as
/// failed. run::Abandoned if the heartbeat says so.
[[nodiscard]] Diagnosis diagnose(std::span<const measure::Measurement> recordings,
                                 DiagnosisOptions options = {});

} // namespace culm::diagnose
