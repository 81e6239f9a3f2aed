// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/search/prediction.hpp"

#include <algorithm>
#include <limits>

namespace culm::diagnose {
namespace {

using Gain = std::optional<PredictedGain>; ///< empty: the effects cannot act there

/// The gain by a set in each unit that has its own numbers: a rig, or every stem.
std::vector<Gain> gains_of(const Stems& stems, const Linearised& about, const std::string& rig,
                           const std::vector<std::size_t>& set) {
    std::vector<Gain> gains;
    const auto add = [&](const EffectColumns& last, const auto& gain) {
        gains.push_back(last.failure.empty() ? Gain(gain()) : std::nullopt);
    };
    if (!rig.empty()) {
        const RigView& view = about.rigs().at(rig);
        add(view.columns[set.back()], [&] { return view.linear.gain(set); });
    } else
        for (const std::size_t s : stems.fitted())
            add(about.view(s).columns[set.back()], [&] { return about.in_stem(s).gain(set); });
    return gains;
}

} // namespace

std::optional<Prediction> predicted(const Stems& stems, const Linearised& about, const Model& base,
                                    const std::string& rig, const std::vector<std::size_t>& set) {
    const double none = -std::numeric_limits<double>::infinity();
    const fit::SelectedEffects& candidates = stems.options().candidates;
    const double odds = static_cast<double>(set.size()) * log_prior_odds();
    const std::vector<Gain> units = gains_of(stems, about, rig, set);
    if (std::ranges::none_of(units, &Gain::has_value))
        return std::nullopt;
    std::vector<double> rises;
    rises.reserve(units.size());
    for (const Gain& unit : units)
        rises.push_back(unit ? unit->log_evidence - odds : none);
    const std::vector<double> presence = presence_of(rises);
    const std::vector<std::size_t> fitted = stems.fitted();
    Prediction out;
    out.effects = base.effects;
    out.candidates = set;
    out.gain = odds;
    for (const std::size_t c : set)
        out.added.emplace_back(OwnedEffect(candidates[c].effect->name, rig), 0.0);
    std::vector<std::size_t> present;
    for (std::size_t k = 0; k < units.size(); ++k) {
        if (!(presence[k] > present_from))
            continue;
        out.gain += rises[k];
        for (std::size_t e = 0; e < set.size(); ++e)
            out.added[e].second += units[k]->points.front().effects[e].fall;
        if (rig.empty()) {
            present.push_back(fitted[k]);
            out.gains[fitted[k]] = *units[k];
        }
    }
    const bool acts = rig.empty() ? !present.empty() : units.front()->log_evidence > none;
    if (rig.empty() && acts)
        out.gain += static_cast<double>(set.size()) * log_presence(present.size(), units.size());
    for (std::size_t e = 0; e < set.size(); ++e)
        out.effects.push_back(rig.empty() || !acts
                                  ? ActingEffect{candidates[set[e]], rig, present, {}, false}
                                  : about.estimated(rig, set[e], e, *units.front()));
    if (!can_be_combined(out.effects, stems))
        return std::nullopt;
    out.gain = acts ? out.gain : none;
    out.log_evidence = base.log_evidence + out.gain;
    return out;
}

} // namespace culm::diagnose
