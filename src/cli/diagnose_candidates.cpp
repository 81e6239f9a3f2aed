// SPDX-License-Identifier: BSD-3-Clause
#include "cli/diagnose_candidates.hpp"

#include "core/error.hpp"
#include "diagnose/diagnosis.hpp"
#include "study/config/study_effects.hpp"

#include <algorithm>
#include <functional>

#include <fmt/format.h>

namespace culm::cli {
namespace {

using fit::SelectedEffects;

bool contains(const SelectedEffects& effects, const std::string& name) {
    return std::ranges::any_of(
        effects, [&name](const auto& selected) { return selected.effect->name() == name; });
}

void add_once(const physics::SelectedEffect& added, SelectedEffects& effects) {
    if (contains(effects, added.effect->name()))
        throw core::InputError(fmt::format("candidate {} is named twice", added.effect->name()));
    effects.push_back(added);
}

} // namespace

DiagnosisEffects effects_for_diagnosis(const std::string& candidates,
                                       const std::vector<std::string>& files,
                                       const std::string& known,
                                       std::span<const measure::Measurement> recordings) {
    DiagnosisEffects out;
    const physics::EffectFileReader read = [&out](const std::string& file) {
        physics::EffectPointer effect = study::read_effect_file(file);
        out.files[effect->name()] = file;
        return effect;
    };
    out.known = fit::in_library_order(physics::parse_effects(known, read));
    SelectedEffects named;
    for (const physics::SelectedEffect& candidate :
         candidates.empty() ? fit::candidate_effects(recordings)
                            : physics::parse_alternatives(candidates, read))
        add_once(candidate, named);
    for (const std::string& file : files)
        add_once(physics::parse_effect(physics::is_effect_file(file) ? file : "./" + file, read),
                 named);
    std::erase_if(named, [&out](const physics::SelectedEffect& candidate) {
        return contains(out.known, candidate.effect->name());
    });
    if (named.empty())
        throw core::InputError("no candidate is left: all of them are --known");
    out.candidates = fit::in_library_order(std::move(named));
    return out;
}

std::string as_option(const std::string& effect, const DiagnosisEffects& effects) {
    const auto file = effects.files.find(effect);
    std::string name = file == effects.files.end() ? effect : file->second;
    for (const SelectedEffects* selection : {&effects.known, &effects.candidates})
        for (const physics::SelectedEffect& selected : *selection)
            if (selected.effect->name() == effect)
                return name + physics::to_string(selected).substr(effect.size());
    return name;
}

} // namespace culm::cli
