// SPDX-License-Identifier: BSD-3-Clause
// Is a larger model accepted in place of a smaller one? The one judgement, for `compare` and
// `diagnose`.
#pragma once

#include "diagnose/criterion.hpp"
#include "diagnose/held_out.hpp"
#include "diagnose/policy.hpp"

#include <optional>
#include <string>
#include <vector>

namespace culm::diagnose {

/// Why a larger model is not accepted, in the order in which it is asked.
enum class Objection {
    None,
    FitFailed,
    Motionless,             ///< nothing moves the stem in this model
    SmallGain,              ///< the criterion falls too little
    NotSignificant,         ///< so many candidates of noise would bring such a gain
    GlaringMisfitStays,     ///< it explains little of a misfit that stays glaring
    NoGainOverRefusedModel, ///< a refused model between the two does as well
    AtBound,                ///< a parameter of an added effect
    NoSize,                 ///< no size of an added effect differs from its absence
    RefitFailed,            ///< of the fit without the readings that are held out
    NotPredictedBetter,     ///< neither part of the readings that were held out
    LastThirdWorse,         ///< is predicted worse
    HeightWorse             ///< likewise
};

/// A larger model that may take the place of a smaller one, which it contains.
struct Step {
    const fit::Fit& smaller;
    const fit::Fit& larger;
    const Criterion& criterion;
    std::vector<std::string> added; ///< effects that have to be there
    std::size_t tried = 1;          ///< candidates among which the larger model was chosen
    /// A model between the two that was refused: the gain must not be that one's.
    const fit::Fit* refused = nullptr;
    std::optional<HeldOutPair> held_out = std::nullopt; ///< empty: not asked yet
};

struct Judgement {
    Objection objection = Objection::None;
    double gain = 0.0;              ///< fall of the criterion
    double p_value = 1.0;           ///< of the gain, for all candidates that were tried
    double explained = 0.0;         ///< share of χ² that the larger model explains
    double gain_over_refused = 0.0; ///< fall of the criterion against Step::refused
    double fall_of_pulls =
        0.0; ///< of the sum of the squared pulls of what was stated; with held_out
    std::vector<std::string> refused;              ///< names of that model
    std::optional<fit::FittedParameter> parameter; ///< that stands at its bound or is not there
    std::string failure;                           ///< of the fit or a refit
    std::optional<HeldOutPair> held_out;

    [[nodiscard]] bool is_accepted() const { return objection == Objection::None; }
    /// Is the gain itself large enough, whatever speaks against its cause?
    [[nodiscard]] bool gains_enough() const {
        return is_accepted() || objection >= Objection::NoGainOverRefusedModel;
    }
};

[[nodiscard]] Judgement judge(const Step& step, const Policy& policy = {});

/// The part of judge() that concerns one effect of a model: it may have failed, stand at a bound,
/// or have no size that differs from its absence. Where recordings have sizes of their own, one
/// that is there is enough.
[[nodiscard]] Judgement judge_effect(const fit::Fit& fit, const std::string& effect);

/// The only place that words objections; "" for None without readings held out.
[[nodiscard]] std::string in_words(const Judgement& judgement, const Policy& policy = {});

/// Could the effect stand in another's place? Also where a parameter ended at a bound, which
/// forbids to name it but does not rule it out, if only it is there at all.
[[nodiscard]] bool is_rival(const fit::Fit& fit, const std::string& effect);

/// Has `larger` no number to fit that `smaller` has not, and explains it nearly all of the misfit?
[[nodiscard]] bool acts_for_certain(const fit::Fit& smaller, const fit::Fit& larger,
                                    const Policy& policy = {});

/// Has the larger model, fitted to its end, explained this share of the misfit above the noise?
[[nodiscard]] bool explains(const fit::Fit& smaller, const fit::Fit& larger, double share);

/// χ² above which a step that adds so many effects leaves a glaring misfit hardly touched.
[[nodiscard]] double step_limit(const fit::Fit& smaller, std::size_t added,
                                const Policy& policy = {});

} // namespace culm::diagnose
