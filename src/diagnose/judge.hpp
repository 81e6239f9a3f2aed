// SPDX-License-Identifier: BSD-3-Clause
// Is a larger model accepted in place of a smaller one? The judgement of `compare`.
#pragma once

#include "diagnose/policy.hpp"
#include "fit/fit_numbers.hpp"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace culm::diagnose {

/// How the misfits of models that are compared are weighted: by the same numbers for all.
struct Criterion {
    std::vector<double> rmse; ///< (recordings) of the best model, m
    double inflation = 1.0;   ///< of χ²: the best model's reduced χ² where that is above 1
    double share = 1.0;       ///< of the readings that count as independent
    double effective_readings = 1.0;
};

/// From the model that fits best, because its residuals are closest to the noise. The second form:
/// the models and one more.
[[nodiscard]] Criterion criterion(std::span<const fit::Fit> models);
[[nodiscard]] Criterion criterion(const fit::Fit& one, std::span<const fit::Fit> others);

/// Bayesian information criterion, M · n/N + k ln n, for N readings of which n count as independent
/// and k fitted numbers. The misfit M is a sum over the recordings: χ²/s where the noise is known,
/// with the inflation s because what the best model misses is noise to all; where only the
/// residuals give the noise, their mean square over that of the best model, times the readings.
[[nodiscard]] double bic(const fit::Fit& model, const Criterion& criterion);

/// Probability of a fall of χ² at least as large by `added` numbers that mean nothing.
[[nodiscard]] double gain_p_value(double gain, int added);
[[nodiscard]] double gain_p_value(const fit::Fit& smaller, const fit::Fit& larger,
                                  const Criterion& criterion);

/// Why a larger model is not accepted, in the order in which it is asked.
enum class Objection {
    None,
    FitFailed,
    Motionless,             ///< nothing moves the stem in this model
    SmallGain,              ///< the criterion falls too little
    NotSignificant,         ///< so many candidates of noise would bring such a gain
    NoGainOverRefusedModel, ///< a refused model between the two does as well
    AtBound,                ///< a parameter of an added effect
    NoSize                  ///< no size of an added effect differs from its absence
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
};

struct Judgement {
    Objection objection = Objection::None;
    double gain = 0.0;                ///< fall of the criterion
    double p_value = 1.0;             ///< of the gain, for all candidates that were tried
    double gain_over_refused = 0.0;   ///< fall of the criterion against Step::refused
    std::vector<std::string> refused; ///< names of that model
    std::optional<fit::FittedParameter> parameter; ///< that stands at its bound or is not there
    std::string failure;                           ///< of the fit or a refit

    [[nodiscard]] bool is_accepted() const { return objection == Objection::None; }
};

[[nodiscard]] Judgement judge(const Step& step, const Policy& policy = {});

/// The part of judge() that concerns one effect of a model: it may have failed, stand at a bound,
/// or have no size that differs from its absence. Where recordings have sizes of their own, one
/// that is there is enough.
[[nodiscard]] Judgement judge_effect(const fit::Fit& fit, const std::string& effect);

/// The only place that words a judgement; "" for an effect without objection.
[[nodiscard]] std::string in_words(const Judgement& judgement, const Policy& policy = {});

} // namespace culm::diagnose
