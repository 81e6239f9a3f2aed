// SPDX-License-Identifier: BSD-3-Clause
// The words of a verdict, on one stem or several.
#include "present/diagnosis.hpp"

#include <ranges>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::present {
namespace {

using diagnose::Conclusion;
using diagnose::Diagnosis;

/// "the published chain", with the known effects.
std::string first_model(const Diagnosis& found) {
    std::vector<std::string> known;
    for (const diagnose::EffectAnswer& each : found.answers)
        if (each.is_known)
            known.push_back(each.effect);
    return known.empty() ? std::string("the published chain")
                         : fmt::format("the published chain with {}", fmt::join(known, " and "));
}

std::string owner_text(const std::string& rig, bool is_one_stem) {
    return is_one_stem ? "" : rig.empty() ? " of stems" : " of rig " + rig;
}

/// "taper", "clamp (clamp_compliance or clamp_friction)", "air of rig A (most like
/// quadratic_drag)".
std::string family_name(const Diagnosis& found, const diagnose::NamedFamily& named) {
    const std::string owner = owner_text(named.rig, found.stems.size() == 1);
    if (named.members.size() == 1 && !named.is_open)
        return named.members.front() + owner;
    return fmt::format("{}{} ({}{})", physics::to_string(named.family), owner,
                       named.is_open ? "most like " : "", fmt::join(named.members, " or "));
}

} // namespace

std::vector<std::string> effect_names(const std::vector<diagnose::OwnedEffect>& effects,
                                      bool is_one_stem) {
    std::vector<std::string> names;
    for (const auto& [effect, rig] : effects)
        names.push_back(effect + owner_text(rig, is_one_stem));
    return names;
}

std::string explanation_name(const Diagnosis& found,
                             const std::vector<diagnose::NamedFamily>& families) {
    const auto name = [&](const diagnose::NamedFamily& named) { return family_name(found, named); };
    return families.empty()
               ? std::string("the published chain")
               : fmt::format("{}", fmt::join(families | std::views::transform(name), " and "));
}

std::string diagnosis_headline(const Diagnosis& found) {
    const bool is_one = found.stems.size() == 1;
    const std::string probability = fmt::format("probability {:.2f}", found.probability);
    switch (found.conclusion) {
    case Conclusion::Adequate:
        return fmt::format("ADEQUATE: {} explains the {} ({}).", first_model(found),
                           is_one ? "recording" : "stems", probability);
    case Conclusion::Unknown:
        if (!is_one)
            return fmt::format("UNKNOWN: {}.", found.reason);
        return found.ladder.front().verdict.finding == diagnose::Finding::Undecided &&
                       found.ladder.size() == 1
                   ? std::string("UNKNOWN: this recording cannot decide whether the model is "
                                 "adequate.")
                   : std::string("UNKNOWN: the model is inadequate, and no known effect explains "
                                 "the misfit.");
    case Conclusion::Effect:
        return fmt::format("EFFECT: {} {} missing from {} ({}).",
                           explanation_name(found, found.alternatives.front().families),
                           found.alternatives.front().families.size() == 1 ? "is" : "are",
                           first_model(found), probability);
    case Conclusion::Tie:
        break;
    }
    return fmt::format("TIE: {} explanations of what is missing from {} hold 95 % of the "
                       "probability.",
                       found.alternatives.size(), first_model(found));
}

std::vector<std::string> explanation_sentences(const Diagnosis& found) {
    std::vector<std::string> sentences;
    if (found.conclusion != Conclusion::Tie)
        return sentences;
    for (const diagnose::FamilyExplanation& each : found.alternatives)
        sentences.push_back(
            fmt::format("{:.2f}  {}", each.probability, explanation_name(found, each.families)));
    if (!found.families.empty())
        sentences.push_back(fmt::format("Certain: {}.", explanation_name(found, found.families)));
    return sentences;
}

} // namespace culm::present
