// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/models/model.hpp"

#include "core/error.hpp"
#include "physics/effects/library.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::diagnose {

bool ActingEffect::acts_in(std::size_t stem) const {
    return std::ranges::find(stems, stem) != stems.end();
}

ActingEffect on_rig(const physics::SelectedEffect& effect, const std::string& rig,
                    const Stems& stems) {
    ActingEffect out{effect, rig, stems.on_rig(rig), {}, false};
    out.values = stem_with(out, out.stems.front(), stems).spec.effects.back().values;
    return out;
}

fit::StemModel stem_with(const ActingEffect& effect, std::size_t stem, const Stems& stems) {
    const measure::Measurement& recording = stems.specimen(stem).recordings.front();
    fit::StemModel model;
    model.spec = fit::chain_of(recording, stems.options().candidate.chain).spec;
    for (const fit::FittedParameter& each : stems[stem].chain.parameters)
        if (each.id == physics::bond_youngs_modulus)
            model.spec.stem.bond_youngs_modulus = each.value;
        else if (each.id == physics::bond_damping)
            model.spec.stem.bond_damping = each.value;
    model.spec.duration = recording.times.back();
    return fit::with_effect(std::move(model), effect.effect, recording);
}

StemEffects Model::effects_of(std::size_t stem, const Stems& all) const {
    StemEffects out;
    for (const ActingEffect& each : effects) {
        if (!each.acts_in(stem))
            continue;
        out.all.push_back(each.effect);
        if (each.is_known || each.is_shared())
            out.given.push_back(each.name());
        if (each.is_shared())
            out.sharing.rig_of[each.name()] = each.rig;
    }
    out.sharing.terms = all.shared_terms();
    return out;
}

std::size_t Model::added() const {
    return static_cast<std::size_t>(std::ranges::count(effects, false, &ActingEffect::is_known));
}

std::vector<OwnedEffect> added_names(const std::vector<ActingEffect>& effects) {
    std::vector<OwnedEffect> names;
    for (const ActingEffect& each : effects)
        if (!each.is_known)
            names.push_back(owned(each));
    return names;
}

std::vector<ActingEffect> without(std::vector<ActingEffect> effects, std::size_t place) {
    effects.erase(effects.begin() + static_cast<std::ptrdiff_t>(place));
    return effects;
}

bool Model::moves() const {
    return std::ranges::any_of(
        stems, [](const StemFit& stem) { return stem.fit.readings > 0 && stem.fit.moves(); });
}

ModelKey key_of(const std::vector<ActingEffect>& effects) {
    ModelKey key;
    for (const ActingEffect& each : effects) {
        std::string& text = key.emplace_back(physics::to_string(each.effect));
        if (each.is_shared())
            text += " of rig " + each.rig;
        for (const std::string& recording : each.effect.absent_from)
            text += " without " + recording;
    }
    std::ranges::sort(key);
    return key;
}

const Model* find_model(const std::vector<Model>& models,
                        const std::vector<ActingEffect>& effects) {
    const auto found = std::ranges::find(models, key_of(effects),
                                         [](const Model& each) { return key_of(each.effects); });
    return found == models.end() ? nullptr : &*found;
}

std::string name_of(const std::vector<ActingEffect>& effects, const Stems& stems) {
    fit::SelectedEffects selected;
    std::vector<std::string> names;
    for (const ActingEffect& each : effects) {
        selected.push_back(each.effect);
        names.push_back(each.is_shared() ? each.name() + " of rig " + each.rig
                                         : each.name() + " of stems");
    }
    if (stems.is_one())
        names = fit::model_names(fit::in_library_order(selected));
    else
        names.insert(names.begin(), "baseline");
    return fmt::format("{}", fmt::join(names, " + "));
}

bool can_be_combined(const fit::SelectedEffects& effects) {
    std::vector<physics::EffectPointer> pointers;
    std::set<physics::Family> laws;
    for (const physics::SelectedEffect& selected : effects) {
        pointers.push_back(selected.effect);
        if (physics::is_one_law(selected.effect->family) &&
            !laws.insert(selected.effect->family).second)
            return false;
    }
    try {
        physics::check_combination(pointers);
    } catch (const core::InputError&) {
        return false;
    }
    return true;
}

bool can_be_combined(const std::vector<ActingEffect>& effects, const Stems& stems) {
    std::set<std::vector<std::size_t>> checked; // effects of a stem
    for (std::size_t s = 0; s < stems.size(); ++s) {
        std::vector<std::size_t> here;
        fit::SelectedEffects selected;
        for (std::size_t e = 0; e < effects.size(); ++e)
            if (effects[e].acts_in(s)) {
                here.push_back(e);
                selected.push_back(effects[e].effect);
            }
        if (checked.insert(here).second && !can_be_combined(selected))
            return false;
    }
    return true;
}

bool contains_all(const std::vector<ActingEffect>& effects, const std::vector<ActingEffect>& some) {
    return std::ranges::all_of(some, [&](const ActingEffect& each) {
        return std::ranges::find(effects, owned(each), owned) != effects.end();
    });
}

bool contains_all(const fit::SelectedEffects& effects, const fit::SelectedEffects& some) {
    return std::ranges::all_of(some,
                               [&](const auto& each) { return fit::contains(effects, each); });
}

std::vector<std::size_t> free_parameters(const physics::SelectedEffect& effect) {
    const std::vector<physics::EffectParameter>& parameters = effect.effect->parameters;
    std::vector<std::size_t> free;
    for (std::size_t k = 0; k < parameters.size(); ++k)
        if (parameters[k].calibrated && !effect.fixed[k])
            free.push_back(k);
    return free;
}

double log_presence(std::size_t with_effect, std::size_t stems) {
    const auto m = static_cast<double>(with_effect);
    const auto n = static_cast<double>(stems);
    const double at_least_one = n / (n + 1.0);
    return std::lgamma(m + 1.0) + std::lgamma(n - m + 1.0) - std::lgamma(n + 2.0) -
           std::log(at_least_one);
}

std::vector<double> presence_of(const std::vector<double>& gains) {
    constexpr int iterations = 50;
    if (gains.size() == 1)
        return {std::isfinite(gains.front()) ? 1.0 : 0.0};
    std::vector<double> probability(gains.size(), 0.0);
    double share = 0.5;
    for (int k = 0; k < iterations; ++k) {
        double sum = 0.0;
        for (std::size_t s = 0; s < gains.size(); ++s) {
            // −infinity: the effect cannot act in this stem.
            const double log_odds = std::log(share / (1.0 - share)) + gains[s];
            probability[s] = 1.0 / (1.0 + std::exp(-log_odds));
            sum += probability[s];
        }
        share = (1.0 + sum) / (2.0 + static_cast<double>(gains.size()));
    }
    return probability;
}

} // namespace culm::diagnose
