// SPDX-License-Identifier: BSD-3-Clause
// The results of culm diagnose for several specimens (docs/laboratory.md).
#pragma once

#include "diagnose/diagnosis.hpp"
#include "present/diagnosis.hpp"

#include <span>
#include <string>
#include <vector>

namespace culm::present {

/// Effects of rigs with their values, one or some lines for each.
[[nodiscard]] std::string rig_effects_text(std::span<const diagnose::EffectAnswer> effects);

/// The same as a list of JSON.
template <class To>
void describe_rig_effects(To& to, const char* key,
                          const std::vector<diagnose::EffectAnswer>& answers) {
    const auto of_rigs = [&] {
        std::vector<diagnose::EffectAnswer> effects = answers;
        std::erase_if(effects, [](const auto& each) { return each.rig.empty(); });
        return effects;
    };
    to.list(key, of_rigs, [&](const diagnose::EffectAnswer& each) {
        to("effect", each.effect);
        to("rig", each.rig);
        to("known", each.is_known);
        to("probability", each.probability);
        to("family", each.family);
        to("family_probability", each.family_probability);
        to("stems_needed", each.stems_needed, "to decide; 0: none, or more do not help");
        to("log_odds", each.log_odds);
        to("log_odds_per_stem", each.log_odds_per_stem);
        to("parameters", each.values);
    });
}

/// laboratory.json.
[[nodiscard]] nlohmann::json laboratory_json(const DiagnosisReport& report);
[[nodiscard]] nlohmann::json laboratory_schema();

/// The verdict, the effects, Y and β over the stems, and the remarkable stems. `with_details`: also
/// the table of all stems and of the fitted models.
[[nodiscard]] std::string laboratory_text(const diagnose::Diagnosis& laboratory, bool with_details);

} // namespace culm::present
