// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/judge.hpp"

#include "fit/solve/residual_statistics.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::diagnose {
namespace {

double readings(const fit::Fit& model) {
    return static_cast<double>(std::max<std::size_t>(model.readings, 1));
}

/// Of each recording its χ², or what stands for it where only the residuals of the best model give
/// the noise: then χ² is the number of its readings whatever the model.
double misfit(const fit::Fit& model, const Criterion& criterion) {
    if (model.misfits.empty())
        return model.chi_squared / criterion.inflation;
    double known = 0.0;
    double unknown = 0.0;
    for (std::size_t m = 0; m < model.misfits.size(); ++m) {
        const fit::RecordingMisfit& own = model.misfits[m];
        const double ratio = m < criterion.rmse.size() ? own.rmse / criterion.rmse[m] : 1.0;
        if (own.is_noise_known)
            known += own.chi_squared;
        else
            unknown += ratio * ratio * static_cast<double>(own.readings);
    }
    return known / criterion.inflation + unknown;
}

const fit::Fit* better(const fit::Fit* best, const fit::Fit& model) {
    return model.is_fitted() && (best == nullptr || deviance(model) < deviance(*best)) ? &model
                                                                                       : best;
}

Criterion criterion_of(const fit::Fit* best) {
    Criterion out;
    if (best == nullptr)
        return out;
    for (const fit::RecordingMisfit& misfit : best->misfits)
        out.rmse.push_back(misfit.rmse);
    out.inflation = std::max(1.0, best->reduced_chi_squared);
    out.effective_readings = std::max(best->effective_readings, 2.0);
    // Correlated residuals carry less evidence than their number says: χ² counts by the share of
    // the readings that are independent, and so does n of the penalty.
    out.share = std::min(1.0, out.effective_readings / readings(*best));
    return out;
}

/// Is the gain of the step large, significant, and no small part of a glaring misfit?
Objection objection_to_gain(const Step& step, const Judgement& judgement, const Policy& policy) {
    if (!(judgement.gain >= policy.naming_gain))
        return Objection::SmallGain;
    if (!(judgement.p_value < policy.naming_level))
        return Objection::NotSignificant;
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

} // namespace

Criterion criterion(std::span<const fit::Fit> models) {
    const fit::Fit* best = nullptr;
    for (const fit::Fit& model : models)
        best = better(best, model);
    return criterion_of(best);
}

Criterion criterion(const fit::Fit& one, std::span<const fit::Fit> others) {
    const fit::Fit* best = better(nullptr, one);
    for (const fit::Fit& model : others)
        best = better(best, model);
    return criterion_of(best);
}

double bic(const fit::Fit& model, const Criterion& criterion) {
    return misfit(model, criterion) * criterion.share +
           static_cast<double>(count_without_errors(model.parameters)) *
               std::log(criterion.effective_readings);
}

double gain_p_value(double gain, int added) {
    return fit::chi_squared_tail(std::max(gain, 0.0), std::max(added, 1));
}

double gain_p_value(const fit::Fit& smaller, const fit::Fit& larger, const Criterion& criterion) {
    return gain_p_value((misfit(smaller, criterion) - misfit(larger, criterion)) * criterion.share,
                        static_cast<int>(larger.parameters.size()) -
                            static_cast<int>(smaller.parameters.size()));
}

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
    if (step.refused != nullptr) {
        judgement.refused = step.refused->names;
        judgement.gain_over_refused =
            bic(*step.refused, step.criterion) - bic(step.larger, step.criterion);
    }
    judgement.objection = objection_to_gain(step, judgement, policy);
    for (const std::string& effect : step.added)
        if (judgement.is_accepted()) {
            const Judgement own = judge_effect(step.larger, effect);
            judgement.objection = own.objection;
            judgement.parameter = own.parameter;
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
        return judgement.gain > 0.0 ? fmt::format("BIC falls by {:.0f}", judgement.gain)
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
    case Objection::NoGainOverRefusedModel:
        return fmt::format("{} against {}, which was refused",
                           gain_in_words(judgement.gain_over_refused),
                           fmt::join(judgement.refused, " + "));
    case Objection::AtBound:
        return bound_in_words(*judgement.parameter);
    case Objection::NoSize:
        return absence_in_words(*judgement.parameter);
    }
    return {};
}

} // namespace culm::diagnose
