// SPDX-License-Identifier: BSD-3-Clause
// The members that diagnosis.json and laboratory.json have in common, and the options of both.
#pragma once

#include "core/describe.hpp"
#include "diagnose/diagnosis.hpp"
#include "physics/bond_law_options.hpp"
#include "physics/effects/effect.hpp"
#include "present/diagnosis.hpp"

#include <optional>
#include <vector>

namespace culm::diagnose {

template <class To>
void describe(To& to, const DiagnosisOptions& options) {
    const auto names = [](const fit::SelectedEffects& effects) {
        std::vector<std::string> texts;
        for (const physics::SelectedEffect& selected : effects)
            texts.push_back(physics::to_string(selected));
        return texts;
    };
    to("law", [&] { return physics::law_name(options.candidate.chain.law); });
    to("spheres", options.candidate.chain.spheres);
    to("window_s", options.candidate.window);
    to("max_effects", options.most_effects);
    to("candidates", [&] { return names(options.candidates); });
    to("known", [&] { return names(options.known); });
}

} // namespace culm::diagnose

namespace culm::present {

template <class To>
void describe_families(To& to, const std::vector<diagnose::NamedFamily>& families) {
    to.list("families", families, [&](const diagnose::NamedFamily& named) {
        to("family", [&] { return physics::to_string(named.family); });
        to("members", named.members, "the likeliest first");
        to("by_family", named.is_open, "true: also laws that the library lacks are possible");
        to.when(!named.rig.empty(), [&] { to("rig", named.rig); });
    });
}

/// The families that the verdict names.
template <class To>
void describe_families_of(To& to, const diagnose::Diagnosis& found) {
    to("reason", found.reason, "of the verdict, one sentence");
    to("probability", found.probability, "of the explanation, or of the published chain");
    describe_families(to, found.families);
    to.list("alternatives", found.alternatives, [&](const diagnose::FamilyExplanation& each) {
        describe_families(to, each.families);
        to("probability", each.probability);
    });
}

/// Explanations of a smaller probability are not listed.
inline constexpr double least_listed = 1e-3;

template <class To>
void describe_answer(To& to, const diagnose::Diagnosis& found) {
    const auto names = [&](const std::vector<diagnose::OwnedEffect>& effects) {
        return effect_names(effects, found.stems.size() == 1);
    };
    const auto listed = [&] {
        std::vector<diagnose::Explanation> explanations = found.posterior.explanations;
        std::erase_if(explanations,
                      [](const auto& each) { return each.probability < least_listed; });
        return explanations;
    };
    describe_families_of(to, found);
    to.list("explanations", listed, [&](const diagnose::Explanation& each) {
        to("effects", [&] { return names(each.effects); });
        to("probability", each.probability);
    });
    to.list("immaterial", found.posterior.immaterial, [&](const diagnose::ImmaterialEffect& each) {
        to("effect", [&] { return names({each.effect}).front(); });
        to("over_noise", each.over_noise, "root mean square that it explains");
    });
    to.list("models", found.posterior.models, [&](const diagnose::ModelProbability& model) {
        const bool has_failed = !model.failure.empty();
        to("effects", [&] { return names(model.effects); });
        to("log_evidence",
           [&] { return has_failed ? std::nullopt : std::optional(model.log_evidence); });
        to("probability", model.probability);
        to.when(has_failed, [&] { to("failure", model.failure); });
    });
}

} // namespace culm::present
