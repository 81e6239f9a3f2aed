// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/candidate_model.hpp"

#include "calibrate/effect_parameters.hpp"
#include "physics/effects/library.hpp"
#include "run/case_model.hpp"

#include <algorithm>
#include <utility>

namespace culm::diagnose {
namespace {

/// Place in the library; behind its end for a user's effect.
std::size_t library_place(const physics::Effect& effect) {
    const std::vector<std::string> names = physics::effect_names();
    return static_cast<std::size_t>(std::ranges::find(names, effect.name()) - names.begin());
}

} // namespace

SelectedEffects in_library_order(SelectedEffects effects) {
    std::ranges::stable_sort(effects, {}, [](const physics::SelectedEffect& selected) {
        return std::pair(library_place(*selected.effect), selected.effect->name());
    });
    return effects;
}

std::vector<std::string> model_names(const SelectedEffects& effects) {
    std::vector<std::string> names{"baseline"};
    for (const physics::SelectedEffect& selected : effects)
        names.push_back(selected.effect->name());
    return names;
}

calibrate::StemModel candidate_model(const calibrate::StemModel& baseline,
                                     const SelectedEffects& effects,
                                     const measure::Measurement& measurement) {
    calibrate::StemModel model = baseline;
    for (const physics::SelectedEffect& selected : in_library_order(effects))
        if (std::ranges::find(selected.absent_from, measurement.stem.id) ==
            selected.absent_from.end())
            model = calibrate::with_effect(std::move(model), selected, measurement);
    return model;
}

bool is_nested(const calibrate::StemModel& model) {
    return std::ranges::all_of(model.spec.effects, [&model](const auto& active) {
        const std::string beginning = active.effect->name() + ".";
        return std::ranges::any_of(model.parameters, [&](const auto& parameter) {
            return parameter.access.name.starts_with(beginning) && !parameter.is_place;
        });
    });
}

bool can_move(const calibrate::StemModel& model, const measure::Measurement& recording) {
    if (recording.release != measure::ReleaseKind::HeldStraight)
        return true;
    const physics::ChainModel<double> chain = run::case_model(model.spec).chain;
    return chain.gravity[1] != 0.0 || !chain.straight_moments.empty() || chain.base_motion ||
           !chain.user_laws.empty();
}

bool has_fitted_number(const physics::Effect& effect) {
    return std::ranges::any_of(effect.parameters(),
                               [](const auto& parameter) { return parameter.calibrated; });
}

SelectedEffects candidate_effects(std::span<const measure::Measurement> recordings) {
    SelectedEffects candidates;
    for (const physics::EffectPointer& effect : physics::all_effects()) {
        if (!effect->is_default_candidate())
            continue;
        const bool needs_direction = std::ranges::any_of(effect->parameters(), [](const auto& of) {
            return of.stated_by == physics::StatedBy::AxialGravity ||
                   of.stated_by == physics::StatedBy::TransverseGravity;
        });
        if (needs_direction &&
            std::ranges::any_of(recordings, [](const measure::Measurement& recording) {
                return recording.gravity_direction == measure::GravityDirection::None;
            }))
            continue;
        candidates.push_back(
            {effect, std::vector<std::optional<double>>(effect->parameters().size())});
    }
    return candidates;
}

} // namespace culm::diagnose
