// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/search/prediction.hpp"
#include "fit/linear/layout.hpp"

#include <algorithm>
#include <iterator>

namespace culm::diagnose {
namespace {

/// Does the size of an effect permit that it is absent from the recording? An effect acts in at
/// least one recording.
bool may_be_absent(const fit::Fit& fit, const physics::SelectedEffect& effect,
                   const std::string& recording) {
    return fit::belongs_to_recording({effect.effect->name, {}, {}}) &&
           effect.absent_from.size() + 1 < fit.misfits.size() &&
           std::ranges::any_of(fit.parameters, [&](const fit::FittedParameter& parameter) {
               return parameter.id.effect == effect.effect->name &&
                      parameter.id.recording == recording && !parameter.is_place &&
                      (is_absent(parameter) || parameter.is_at_bound);
           });
}

/// The effects with number `k`, which stems have, shared by the rig; its numbers are the means of
/// the stems'.
std::vector<ActingEffect> shared_instead(const Model& model, std::size_t k, const std::string& rig,
                                         const Stems& stems) {
    std::vector<ActingEffect> effects = model.effects;
    ActingEffect& shared = effects[k] = on_rig(effects[k].effect, rig, stems);
    const std::vector<physics::EffectParameter>& cards = shared.effect.effect->parameters;
    for (std::size_t c = 0; c < cards.size(); ++c) {
        double sum = 0.0;
        double count = 0.0;
        for (const std::size_t s : model.effects[k].stems)
            for (const fit::FittedParameter& each : model.stems[s].fit.parameters)
                if (each.id.effect == shared.name() && each.id.name == cards[c].name) {
                    sum += fit::to_coordinate(each.fitted_as, each.value);
                    count += 1.0;
                }
        if (count > 0.0)
            shared.values[c] = fit::from_coordinate(cards[c].fitted_as, sum / count);
    }
    return effects;
}

/// Recordings from which effect number `k` may be absent.
std::vector<std::string> absences(const Model& model, std::size_t k, const Stems& stems) {
    std::vector<std::string> out;
    const ActingEffect& effect = model.effects[k];
    for (const std::size_t s : effect.stems)
        for (const measure::Measurement& recording : stems.specimen(s).recordings)
            if (!effect.is_shared() &&
                may_be_absent(model.stems[s].fit, effect.effect, recording.stem.id))
                out.push_back(recording.stem.id);
    return out;
}

/// The effects with number `k` replaced by a candidate that it contains: friction and slip contain
/// the spring of their clamp.
std::vector<std::vector<ActingEffect>> contained_instead(const Model& model, std::size_t k,
                                                         const Stems& stems) {
    std::vector<std::vector<ActingEffect>> out;
    const std::vector<std::string>& contained = model.effects[k].effect.effect->excludes;
    for (const physics::SelectedEffect& candidate : stems.options().candidates)
        if (std::ranges::find(contained, candidate.effect->name) != contained.end()) {
            ActingEffect& smaller = out.emplace_back(model.effects)[k];
            if (smaller.is_shared())
                smaller = on_rig(candidate, smaller.rig, stems);
            else
                smaller.effect = candidate;
        }
    return out;
}

} // namespace

std::vector<std::vector<ActingEffect>> neighbours_of(const Model& model, const Stems& stems,
                                                     bool with_contained) {
    std::vector<std::vector<ActingEffect>> out;
    for (std::size_t k = 0; k < model.effects.size(); ++k) {
        const ActingEffect& effect = model.effects[k];
        if (effect.is_known)
            continue;
        if (model.added() > 1)
            out.push_back(without(model.effects, k));
        if (with_contained)
            std::ranges::move(contained_instead(model, k, stems), std::back_inserter(out));
        if (!effect.is_shared() && effect.effect.effect->belongs_to == physics::BelongsTo::Rig)
            for (const std::string& rig : stems.rigs())
                out.push_back(shared_instead(model, k, rig, stems));
        for (const std::string& recording : absences(model, k, stems)) {
            std::vector<std::string>& absent =
                out.emplace_back(model.effects)[k].effect.absent_from;
            absent.push_back(recording);
            std::ranges::sort(absent);
        }
    }
    return out;
}

} // namespace culm::diagnose
