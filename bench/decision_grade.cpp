// SPDX-License-Identifier: BSD-3-Clause
#include "bench/decision_grade.hpp"

#include "physics/effects/library.hpp"

#include <algorithm>
#include <map>
#include <set>

namespace culm::bench {

bool is_in_library(const std::string& name) {
    const std::vector<std::string> names = physics::effect_names();
    return std::ranges::find(names, name) != names.end();
}

std::string family_of(const std::string& effect) {
    if (effect == "cubic_drag")
        return std::string(physics::to_string(physics::Family::Air));
    if (effect == "curvature_damping" || effect == second_loss)
        return std::string(physics::to_string(physics::Family::MaterialDamping));
    const physics::Family family =
        is_in_library(effect) ? physics::effect_named(effect)->family : physics::Family::Own;
    return physics::is_one_law(family) ? std::string(physics::to_string(family)) : std::string();
}

namespace {

/// The library's laws that contain others, and those.
const std::map<std::string, std::set<std::string>> general_laws{
    {"power_drag", {"viscous_drag", "quadratic_drag"}},
    {"fractional_zener", {"hysteretic_damping", "relaxation"}}};

/// Is the law the effect, or a general one that contains it?
bool covers(const std::string& law, const std::string& effect) {
    const auto general = general_laws.find(law);
    return law == effect || (general != general_laws.end() && general->second.contains(effect));
}

bool stands_for(const NamedEffects& named, const HiddenTruth& hidden) {
    if (!hidden.family.empty())
        return named.family == hidden.family;
    if (is_in_library(hidden.effect))
        return std::ranges::any_of(
            named.members, [&](const auto& member) { return covers(member, hidden.effect); });
    const bool is_open = named.members.size() > 1 || general_laws.contains(named.members.front());
    return named.family == family_of(hidden.effect) && is_open;
}

bool names_no_other(const AnswerSet& named, const std::vector<HiddenTruth>& hidden) {
    return std::ranges::all_of(named, [&](const NamedEffects& each) {
        return std::ranges::any_of(
            hidden, [&](const HiddenTruth& truth) { return stands_for(each, truth); });
    });
}

} // namespace

bool is_truth(const AnswerSet& named, const std::vector<HiddenTruth>& hidden) {
    return names_no_other(named, hidden) &&
           std::ranges::all_of(hidden, [&](const HiddenTruth& truth) {
               return !truth.is_material || std::ranges::any_of(named, [&](const auto& each) {
                   return stands_for(each, truth);
               });
           });
}

bool is_named(const Answered& answer, const HiddenTruth& hidden) {
    return std::ranges::any_of(answer.certain,
                               [&](const auto& each) { return stands_for(each, hidden); });
}

std::string grade(const Answered& answer, const std::vector<HiddenTruth>& hidden) {
    const bool is_outside = std::ranges::any_of(hidden, [](const HiddenTruth& truth) {
        return truth.effect != second_loss && !is_in_library(truth.effect);
    });
    if (answer.verdict == "failed")
        return "failed";
    if (answer.verdict == "unknown")
        return is_outside ? "right" : "unknown";
    if (answer.verdict == "adequate")
        return is_truth({}, hidden) ? "right" : "silent";
    if (!names_no_other(answer.certain, hidden))
        return "wrong";
    if (answer.verdict == "effect")
        return is_truth(answer.certain, hidden) ? "right" : "partly";
    return std::ranges::any_of(answer.candidates,
                               [&](const auto& each) { return is_truth(each, hidden); })
               ? "tie"
               : "wrong";
}

void to_json(nlohmann::json& json, const NamedEffects& named) {
    json = {{"family", named.family}, {"members", named.members}};
}

void from_json(const nlohmann::json& json, NamedEffects& named) {
    json.at("family").get_to(named.family);
    json.at("members").get_to(named.members);
}

} // namespace culm::bench
