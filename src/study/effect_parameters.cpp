// SPDX-License-Identifier: BSD-3-Clause
#include "study/effect_parameters.hpp"

#include <algorithm>
#include <utility>

namespace culm::study {
namespace {

std::shared_ptr<const EffectParameterRow> row_of(const physics::Effect& effect,
                                                 const physics::EffectParameter& parameter,
                                                 EffectPlace place) {
    auto row = std::make_shared<EffectParameterRow>();
    row->key = effect.name() + "." + parameter.name;
    row->unit = parameter.unit;
    row->meaning = parameter.meaning;
    row->parameter.key = row->key;
    row->parameter.section = "effects";
    row->parameter.unit = {row->unit, "", Dimension::None};
    row->parameter.range = {parameter.lower, parameter.upper};
    row->parameter.meaning = row->meaning;
    row->parameter.effect = place;
    return row;
}

} // namespace

StudyEffects::StudyEffects(std::vector<physics::SelectedEffect> selected)
    : selected_(std::move(selected)) {
    for (std::size_t effect = 0; effect < selected_.size(); ++effect) {
        const auto parameters = selected_[effect].effect->parameters();
        for (std::size_t value = 0; value < parameters.size(); ++value)
            rows_.push_back(row_of(*selected_[effect].effect, parameters[value], {effect, value}));
    }
}

const Parameter* StudyEffects::find(std::string_view key) const {
    const auto found =
        std::ranges::find_if(rows_, [key](const auto& row) { return row->key == key; });
    return found == rows_.end() ? nullptr : &(*found)->parameter;
}

std::vector<std::string> StudyEffects::keys() const {
    std::vector<std::string> keys;
    for (const auto& row : rows_)
        keys.push_back(row->key);
    return keys;
}

std::vector<physics::ActiveEffect>
StudyEffects::with_defaults(const physics::StemParameters<double>& stem) const {
    std::vector<physics::ActiveEffect> active;
    for (const physics::SelectedEffect& selected : selected_)
        active.push_back(physics::with_defaults(selected, stem));
    return active;
}

} // namespace culm::study
