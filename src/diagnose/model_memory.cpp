// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/model_memory.hpp"

#include <algorithm>

namespace culm::diagnose {

const fit::Fit* ModelMemory::fit_of(const fit::SelectedEffects& effects) const {
    const auto found = fits_.find(key_of(effects));
    return found == fits_.end() ? nullptr : &found->second;
}

void ModelMemory::keep(const fit::SelectedEffects& effects, const fit::Fit& fit) {
    if (!fit.is_fitted())
        return;
    const auto [place, is_new] = fits_.try_emplace(key_of(effects), fit);
    if (!is_new && fit.chi_squared < place->second.chi_squared)
        place->second = fit;
}

const std::vector<EffectScore>*
ModelMemory::scores_beside(const fit::SelectedEffects& effects) const {
    const auto found = scores_.find(key_of(effects));
    return found == scores_.end() ? nullptr : &found->second;
}

void ModelMemory::keep(const fit::SelectedEffects& effects,
                       const std::vector<EffectScore>& scores) {
    scores_.insert_or_assign(key_of(effects), scores);
}

ModelMemory::Key ModelMemory::key_of(const fit::SelectedEffects& effects) {
    Key key;
    for (const physics::SelectedEffect& selected : effects) {
        std::string& text = key.emplace_back(physics::to_string(selected));
        for (const std::string& recording : selected.absent_from)
            text += " without " + recording;
    }
    std::ranges::sort(key);
    return key;
}

} // namespace culm::diagnose
