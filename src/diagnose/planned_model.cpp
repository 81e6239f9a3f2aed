// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/planned_model.hpp"

#include "core/error.hpp"
#include "fit/solve/layout.hpp"
#include "physics/effects/library.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace culm::diagnose {
namespace {

/// Position along the secant from the model without the effect to the node, as a fraction.
double way_to(const EffectNode& node, const std::vector<double>& amounts) {
    const double secant = node.columns.front().secant;
    return secant == 0.0 ? 1.0 : amounts.front() / secant;
}

/// Size `k` among the effect's parameters, as a coordinate; `value` if the node has no column for
/// it. If recordings have separate sizes, each has its own column.
double size_of(const EffectNode& node, const std::vector<double>& amounts, std::size_t k,
               std::size_t recording, const ParameterPrior& prior, double value) {
    const bool has_own = std::ranges::count(node.columns, k, &EffectColumn::parameter) > 1;
    double coordinate = prior.absent;
    std::size_t seen = 0;
    for (std::size_t c = 0; c < node.columns.size(); ++c) {
        if (node.columns[c].parameter != k)
            continue;
        if (!has_own || seen == recording)
            coordinate += amounts[c] * prior.deviation;
        ++seen;
    }
    return seen > 0 ? coordinate : value;
}

void place_effect(const CandidateView& view, const EffectNode& node,
                  const std::vector<double>& amounts, std::size_t recording,
                  fit::StemModel& model) {
    const std::string name = view.effect.effect->name();
    std::size_t k = 0;
    for (const fit::FreeParameter& parameter : model.parameters) {
        if (parameter.access.id.effect != name)
            continue;
        double value = node.values[k];
        if (!parameter.is_place)
            value = from_coordinate(parameter.fitted_as,
                                    size_of(node, amounts, k, recording, prior_of(parameter, model),
                                            to_coordinate(parameter.fitted_as, value)));
        if (!std::isfinite(value)) // a stiffness without compliance
            value = parameter.upper;
        parameter.access.set(model.spec, std::clamp(value, parameter.lower, parameter.upper));
        ++k;
    }
}

void set_superposed(fit::StartModels& models, bool is_superposed) {
    for (fit::StemModel& model : models)
        model.is_superposed = is_superposed;
}

/// Models that start from the fit are superposed too.
fit::Fit superposed(fit::Fit fit) {
    for (fit::RecordingFit& part : fit.parts)
        part.model.is_superposed = true;
    return fit;
}

bool is_superposable(const fit::SelectedEffects& effects) {
    return std::ranges::any_of(effects, [](const physics::SelectedEffect& selected) {
        std::vector<double> values;
        for (const physics::EffectParameter& each : selected.effect->parameters())
            values.push_back(each.default_value);
        return !selected.effect->planar_parts(values).empty();
    });
}

fit::Fit fitted(const fit::SelectedEffects& effects, const std::optional<fit::StartModels>& start,
                const fit::Fit& smaller, std::span<const fit::ObservedRecording> recordings,
                const fit::FitOptions& options) {
    fit::Fit fit;
    if (start && smaller.moves())
        fit = fit::refined(*start, effects, smaller, recordings, options);
    if (fit.failed()) {
        const int runs = fit.runs;
        fit = fit::fit_with_parts(effects, smaller, recordings, options);
        fit.runs += runs;
    }
    return fit;
}

/// Does the size of effect number `place` of the fit permit that the effect is absent from the
/// recording? An effect acts in at least one recording.
bool may_be_absent(const fit::Fit& fit, std::size_t place, const std::string& recording) {
    const physics::SelectedEffect& effect = fit.effects[place];
    return fit::belongs_to_recording({effect.effect->name(), {}, {}}) &&
           effect.absent_from.size() + 1 < fit.misfits.size() &&
           std::ranges::any_of(fit.parameters, [&](const fit::FittedParameter& parameter) {
               return parameter.id.effect == effect.effect->name() &&
                      parameter.id.recording == recording && !parameter.is_place &&
                      (is_absent(parameter) || parameter.is_at_bound);
           });
}

} // namespace

ModelKey key_of(const fit::SelectedEffects& effects) {
    ModelKey key;
    for (const physics::SelectedEffect& selected : effects) {
        std::string& text = key.emplace_back(physics::to_string(selected));
        for (const std::string& recording : selected.absent_from)
            text += " without " + recording;
    }
    std::ranges::sort(key);
    return key;
}

bool can_be_combined(const fit::SelectedEffects& effects) {
    std::vector<physics::EffectPointer> pointers;
    std::set<physics::Family> laws;
    for (const physics::SelectedEffect& selected : effects) {
        pointers.push_back(selected.effect);
        if (physics::is_one_law(selected.effect->family()) &&
            !laws.insert(selected.effect->family()).second)
            return false;
    }
    try {
        physics::check_combination(pointers);
    } catch (const core::InputError&) {
        return false;
    }
    return true;
}

fit::StartModels
start_at_estimate(const fit::Fit& base, std::span<const fit::ObservedRecording> recordings,
                  const std::vector<CandidateView>& views, const LinearEvidence& linear,
                  const std::vector<std::size_t>& chosen, const PredictedGain& gain) {
    fit::StartModels models = fit::start_from(base);
    const fit::JointLayout layout = fit::joint_layout(models, recordings);
    models = moved(std::move(models), layout, linear.own_change(chosen, gain));
    for (std::size_t e = 0; e < chosen.size(); ++e) {
        const CandidateView& view = views[chosen[e]];
        const EffectNode& node = view.columns.nodes[gain.nodes[e]];
        const double share = way_to(node, gain.amounts[e]);
        for (std::size_t m = 0; m < models.size(); ++m) {
            models[m] = candidate_model(models[m], {view.effect}, recordings[m]);
            models[m].spec.stem.bond_youngs_modulus *= std::pow(node.modulus_ratio, share);
            models[m].spec.stem.bond_damping *= std::pow(node.damping_ratio, share);
            place_effect(view, node, gain.amounts[e], m, models[m]);
        }
    }
    return models;
}

std::string special_case_of(const physics::Effect& general, const fit::Fit& fit) {
    std::string name = general.name();
    std::size_t count = 0;
    for (const physics::SpecialCase& special : general.special_cases()) {
        const auto found = std::ranges::find_if(fit.parameters, [&](const auto& parameter) {
            return parameter.id.effect == general.name() && parameter.id.name == special.parameter;
        });
        if (found == fit.parameters.end())
            continue;
        const double half_width = interval_half_width(*found);
        const bool is_beyond_bound =
            (special.value > found->upper && found->value + half_width >= found->upper) ||
            (special.value < found->lower && found->value - half_width <= found->lower);
        if (is_beyond_bound || std::abs(found->value - special.value) <= half_width) {
            ++count;
            name = special.effect;
        }
    }
    return count == 1 ? name : general.name();
}

bool contains_all(const fit::SelectedEffects& effects, const fit::SelectedEffects& some) {
    return std::ranges::all_of(some,
                               [&](const auto& each) { return fit::contains(effects, each); });
}

std::vector<fit::SelectedEffects>
sets_to_compare(const fit::Fit& fit, std::span<const fit::ObservedRecording> recordings,
                std::size_t known, const fit::SelectedEffects& candidates) {
    std::vector<fit::SelectedEffects> sets;
    const fit::SelectedEffects& effects = fit.effects;
    for (std::size_t k = known; k < effects.size(); ++k) {
        if (effects.size() > known + 1) {
            fit::SelectedEffects& smaller = sets.emplace_back(effects);
            smaller.erase(smaller.begin() + static_cast<std::ptrdiff_t>(k));
        }
        const std::string law = special_case_of(*effects[k].effect, fit);
        for (const physics::SelectedEffect& special : candidates)
            if (special.effect->name() == law && law != effects[k].effect->name())
                sets.emplace_back(effects)[k] = {special.effect, special.fixed,
                                                 effects[k].absent_from};
        for (const measure::Measurement& recording : recordings)
            if (may_be_absent(fit, k, recording.stem.id)) {
                std::vector<std::string>& absent = sets.emplace_back(effects)[k].absent_from;
                absent.push_back(recording.stem.id);
                std::ranges::sort(absent);
            }
    }
    return sets;
}

fit::Fit without(fit::Fit fit, const std::vector<std::string>& names) {
    const auto is_one = [&](const std::string& name) {
        return std::ranges::find(names, name) != names.end();
    };
    std::erase_if(fit.effects, [&](const auto& each) { return is_one(each.effect->name()); });
    std::erase_if(fit.parameters, [&](const auto& each) { return is_one(each.id.effect); });
    return fit;
}

FittedModel fit_planned(const PlannedModel& planned, const fit::Fit& smaller,
                        std::span<const fit::ObservedRecording> recordings,
                        const fit::SelectedEffects& known, const fit::FitOptions& options) {
    fit::Fit fit;
    if (is_superposable(planned.effects) && smaller.moves()) {
        std::optional<fit::StartModels> start = planned.start;
        if (start)
            set_superposed(*start, true);
        const fit::Fit near =
            fitted(planned.effects, start, superposed(smaller), recordings, options);
        if (!near.failed()) {
            start = fit::start_from(near);
            set_superposed(*start, false);
            fit = fit::refined(*start, planned.effects, smaller, recordings, options);
            fit.runs += near.runs;
        }
    }
    if (fit.failed()) {
        const int runs = fit.runs;
        fit = fitted(planned.effects, planned.start, smaller, recordings, options);
        fit.runs += runs;
    }
    FittedModel out;
    if (!fit.failed())
        out.evidence = evidence_of(fit, recordings, known);
    out.fit = fit::numbers_of(fit);
    return out;
}

} // namespace culm::diagnose
