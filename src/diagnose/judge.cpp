// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/judge.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::diagnose {
namespace {

/// Sum of the squared pulls of what was stated of the stem and the picture: a reading of a ruler is
/// one that neither held-out part leaves out.
double squared_pulls(const fit::Fit& fit) {
    double sum = 0.0;
    for (const fit::FittedParameter& parameter : fit.parameters)
        if (parameter.is_error)
            sum += parameter.value * parameter.value;
    return sum;
}

Objection objection_of_held_out(const HeldOutPair& both, double fall_of_pulls,
                                const Policy& policy) {
    const HeldOutPart& time = both.larger.last_third;
    const HeldOutPart& height = both.larger.one_height;
    const HeldOut& before = both.smaller;
    if (!time.failure.empty())
        return Objection::RefitFailed;
    // A late part of the record that has died down says nothing of the modes' shapes, and one row
    // little of a slow drift: one of the two has to be predicted better, neither worse. A model may
    // predict both well because it contradicts the ruler: a soft clamp as a clamp 28 standard
    // uncertainties away from where it was seen. Then that statement is predicted better.
    const bool has_height = height.failure.empty() && before.one_height.failure.empty();
    const bool is_time_better = is_predicted_better(time, before.last_third, policy);
    const bool is_height_better =
        has_height && is_predicted_better(height, before.one_height, policy);
    if (!is_time_better && !is_height_better && !(fall_of_pulls > policy.held_out_gain))
        return Objection::NotPredictedBetter;
    if (predicts_better(before.last_third, time, policy))
        return Objection::LastThirdWorse;
    if (has_height && height.over_noise > policy.allowed_rise * before.one_height.over_noise)
        return Objection::HeightWorse;
    return Objection::None;
}

/// Is the gain of the step large, significant, and no small part of a glaring misfit?
Objection objection_to_gain(const Step& step, const Judgement& judgement, const Policy& policy) {
    if (!(judgement.gain >= policy.naming_gain))
        return Objection::SmallGain;
    if (!(judgement.p_value < policy.naming_level))
        return Objection::NotSignificant;
    const std::size_t added = step.larger.names.size() - step.smaller.names.size();
    if (step.larger.chi_squared > step_limit(step.smaller, added, policy))
        return Objection::GlaringMisfitStays;
    if (step.refused != nullptr && !(judgement.gain_over_refused >= policy.naming_gain))
        return Objection::NoGainOverRefusedModel;
    return Objection::None;
}

std::string gain_in_words(double gain) {
    return fmt::format("BIC {} by {:.1f}", gain < 0.0 ? "rises" : "falls", std::abs(gain));
}

std::string bound_in_words(const fit::FittedParameter& parameter) {
    return fmt::format("{} stands at its bound, {:.4g}{}{}", to_string(parameter.id),
                       parameter.value, parameter.unit.empty() ? "" : " ", parameter.unit);
}

std::string absence_in_words(const fit::FittedParameter& parameter) {
    const bool is_inverse = parameter.fitted_as == physics::FittedAs::Inverse;
    return fmt::format("{} = {:.4g} ± {:.2g} {}is no different from {}", to_string(parameter.id),
                       parameter.value, interval_half_width(parameter),
                       parameter.unit.empty() ? "" : parameter.unit + " ",
                       is_inverse ? "an infinite one" : fmt::format("{:g}", parameter.absent));
}

/// Which part of the readings that were held out is predicted better.
std::string acceptance_in_words(const Judgement& judgement, const Policy& policy) {
    const HeldOutPair& both = *judgement.held_out;
    const bool is_time =
        is_predicted_better(both.larger.last_third, both.smaller.last_third, policy);
    const HeldOut& seen = both.larger;
    if (!is_time && !is_predicted_better(seen.one_height, both.smaller.one_height, policy))
        return fmt::format("what was stated of the stem and the picture is contradicted less (sum "
                           "of the squared pulls lower by {:.0f})",
                           judgement.fall_of_pulls);
    const HeldOutPart& after = is_time ? seen.last_third : seen.one_height;
    const HeldOutPart& before = is_time ? both.smaller.last_third : both.smaller.one_height;
    return fmt::format("the {} is predicted better ({:.2f} times the noise, before {:.2f})",
                       is_time ? "last third of the time" : "height that was left out",
                       after.over_noise, before.over_noise);
}

std::string held_out_in_words(Objection objection, const HeldOutPair& both) {
    const HeldOut& after = both.larger;
    const HeldOut& before = both.smaller;
    switch (objection) {
    case Objection::RefitFailed:
        return "the fit to the first two thirds failed: " + after.last_third.failure;
    case Objection::NotPredictedBetter:
        return fmt::format("neither the last third of the time ({:.3f} times the noise, before "
                           "{:.3f}) nor the height that was left out is predicted better",
                           after.last_third.over_noise, before.last_third.over_noise);
    case Objection::LastThirdWorse:
        return fmt::format("the last third of the time is predicted worse ({:.3f} times the noise, "
                           "before {:.3f})",
                           after.last_third.over_noise, before.last_third.over_noise);
    default:
        return fmt::format("the height that was left out is predicted worse ({:.3f} times the "
                           "noise, before {:.3f})",
                           after.one_height.over_noise, before.one_height.over_noise);
    }
}

} // namespace

Judgement judge(const Step& step, const Policy& policy) {
    Judgement judgement;
    if (step.larger.failed()) {
        judgement.objection = Objection::FitFailed;
        judgement.failure = step.larger.reason;
        return judgement;
    }
    judgement.gain = bic(step.smaller, step.criterion) - bic(step.larger, step.criterion);
    if (!step.larger.moves()) {
        judgement.objection = Objection::Motionless;
        return judgement;
    }
    // Bonferroni: the best of so many candidates was chosen after all were seen.
    judgement.p_value =
        std::min(1.0, gain_p_value(step.smaller, step.larger, step.criterion) *
                          static_cast<double>(std::max<std::size_t>(step.tried, 1)));
    judgement.explained = 1.0 - step.larger.chi_squared / step.smaller.chi_squared;
    if (step.refused != nullptr) {
        judgement.refused = step.refused->names;
        judgement.gain_over_refused =
            bic(*step.refused, step.criterion) - bic(step.larger, step.criterion);
    }
    // From the cheapest to the dearest question: what is held out costs four fits and is asked
    // last.
    judgement.objection = objection_to_gain(step, judgement, policy);
    for (const std::string& effect : step.added)
        if (judgement.is_accepted()) {
            const Judgement own = judge_effect(step.larger, effect);
            judgement.objection = own.objection;
            judgement.parameter = own.parameter;
        }
    if (judgement.is_accepted() && step.held_out) {
        judgement.held_out = step.held_out;
        judgement.fall_of_pulls = squared_pulls(step.smaller) - squared_pulls(step.larger);
        judgement.objection =
            objection_of_held_out(*step.held_out, judgement.fall_of_pulls, policy);
    }
    return judgement;
}

Judgement judge_effect(const fit::Fit& fit, const std::string& effect) {
    Judgement judgement;
    if (fit.failed()) {
        judgement.objection = Objection::FitFailed;
        judgement.failure = fit.reason;
        return judgement;
    }
    if (!fit.moves()) {
        judgement.objection = Objection::Motionless;
        return judgement;
    }
    bool has_size = false;
    bool is_there = false;
    bool has_own_sizes = false;
    std::optional<fit::FittedParameter> at_bound;
    std::optional<fit::FittedParameter> absent;
    for (const fit::FittedParameter& parameter : fit.parameters) {
        if (parameter.id.effect != effect)
            continue;
        const bool is_size = !parameter.is_place;
        has_size = has_size || is_size;
        const bool stands_absent = is_size && is_absent(parameter);
        is_there = is_there || (is_size && !parameter.is_at_bound && !stands_absent);
        if (parameter.is_at_bound) {
            at_bound = parameter;
            has_own_sizes = parameter.id.is_one_recordings_own();
        } else if (stands_absent) {
            absent = parameter;
        }
    }
    // An estimate at a bound has no interval, so neither its size nor its absence is known. Of
    // several recordings one may well lie at none while another carries the effect.
    if (at_bound && !(has_own_sizes && is_there)) {
        judgement.objection = Objection::AtBound;
        judgement.parameter = at_bound;
    } else if (has_size && !is_there && absent) {
        judgement.objection = Objection::NoSize;
        judgement.parameter = absent;
    }
    return judgement;
}

std::string in_words(const Judgement& judgement, const Policy& policy) {
    switch (judgement.objection) {
    case Objection::None:
        return judgement.held_out ? fmt::format("BIC falls by {:.0f}, {}", judgement.gain,
                                                acceptance_in_words(judgement, policy))
                                  : std::string();
    case Objection::FitFailed:
        return "failed: " + judgement.failure;
    case Objection::Motionless:
        return "nothing moves the stem in this model";
    case Objection::SmallGain:
        return judgement.gain < 0.0
                   ? gain_in_words(judgement.gain)
                   : fmt::format("{}, less than {:g}", gain_in_words(judgement.gain),
                                 policy.naming_gain);
    case Objection::NotSignificant:
        return fmt::format("the gain is not significant (p = {:.2g})", judgement.p_value);
    case Objection::GlaringMisfitStays:
        return fmt::format("it explains {:.0f} % of a misfit that stays glaring",
                           100.0 * judgement.explained);
    case Objection::NoGainOverRefusedModel:
        return fmt::format("{} against {}, which was refused",
                           gain_in_words(judgement.gain_over_refused),
                           fmt::join(judgement.refused, " + "));
    case Objection::AtBound:
        return bound_in_words(*judgement.parameter);
    case Objection::NoSize:
        return absence_in_words(*judgement.parameter);
    case Objection::RefitFailed:
    case Objection::NotPredictedBetter:
    case Objection::LastThirdWorse:
    case Objection::HeightWorse:
        return held_out_in_words(judgement.objection, *judgement.held_out);
    }
    return {};
}

bool is_rival(const fit::Fit& fit, const std::string& effect) {
    if (!fit.is_fitted())
        return false;
    bool has_size = false;
    bool is_there = false;
    for (const fit::FittedParameter& parameter : fit.parameters) {
        if (parameter.id.effect != effect || parameter.is_place)
            continue;
        has_size = true;
        is_there = is_there || !is_absent(parameter);
    }
    return is_there || !has_size;
}

bool acts_for_certain(const fit::Fit& smaller, const fit::Fit& larger, const Policy& policy) {
    return larger.parameters.size() <= smaller.parameters.size() &&
           larger.chi_squared < policy.certain_share * smaller.chi_squared;
}

bool explains(const fit::Fit& smaller, const fit::Fit& larger, double share) {
    const auto readings = static_cast<double>(smaller.readings);
    return larger.is_fitted() && !larger.out_of_reach &&
           larger.chi_squared - readings < (1.0 - share) * (smaller.chi_squared - readings);
}

double step_limit(const fit::Fit& smaller, std::size_t added, const Policy& policy) {
    const auto readings = static_cast<double>(smaller.readings);
    const double share = policy.least_share_of_glaring * static_cast<double>(added);
    return std::max(policy.glaring_misfit * readings,
                    smaller.chi_squared - share * (smaller.chi_squared - readings));
}

} // namespace culm::diagnose
