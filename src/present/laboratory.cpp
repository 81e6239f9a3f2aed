// SPDX-License-Identifier: BSD-3-Clause
#include "present/laboratory.hpp"

#include "present/diagnosis.hpp"
#include "present/files.hpp"
#include "present/parameters.hpp"
#include "present/text.hpp"
#include "reduce/distributions.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::present {
namespace {

using Laboratory = diagnose::Diagnosis;
using diagnose::StemAnswer;
using nlohmann::json;

constexpr double pascals_per_gpa = 1e9;

std::string with_unit(double value, const std::string& unit) {
    return fmt::format("{:.3g}{}{}", value, unit.empty() ? "" : " ", unit);
}

std::string header(const Laboratory& laboratory) {
    std::map<std::string, std::size_t> rigs;
    std::size_t left_out = 0;
    for (const StemAnswer& stem : laboratory.stems) {
        ++rigs[stem.rig];
        left_out += stem.failure.empty() ? 0 : 1;
    }
    std::vector<std::string> places;
    for (const auto& [rig, count] : rigs)
        places.push_back(rig.empty() ? fmt::format("{} without a stated rig", count)
                                     : fmt::format("{} on rig {}", count, rig));
    std::string text =
        fmt::format("{}: {}", counted(laboratory.stems.size(), "stem"), fmt::join(places, ", "));
    if (left_out > 0)
        text += fmt::format("; {} left out", left_out);
    return text + "\n\n";
}

std::string effect_lines(const diagnose::EffectAnswer& effect) {
    std::string line = effect_names({{effect.effect, effect.rig}}, false).front();
    if (effect.is_known)
        line += ", known";
    else
        line += fmt::format(", probability {:.2f}", effect.probability);
    if (!effect.is_known && effect.family_probability > effect.probability + 0.005)
        line +=
            fmt::format(" ({} of {})", number_cell(effect.family_probability, 2), effect.family);
    if (effect.stems_needed > 0.0)
        line += fmt::format("; about {} like these would decide",
                            counted(static_cast<std::size_t>(effect.stems_needed), "stem"));
    if (!effect.stems.empty())
        line += fmt::format(": {}", fmt::join(effect.stems, ", "));
    if (!effect.possible_stems.empty())
        line += fmt::format("; possible in {}", fmt::join(effect.possible_stems, ", "));
    std::string text = result_lines("  ", line);
    for (const diagnose::SharedValue& value : effect.values)
        text += fmt::format("    {:<38} {}  (95 %: {:.3g} to {:.3g})\n",
                            effect.effect + "." + value.name, with_unit(value.value, value.unit),
                            value.lower, value.upper);
    return text;
}

std::string population_lines(const Laboratory& laboratory) {
    const diagnose::Population& before = laboratory.before;
    const diagnose::Population& after = laboratory.after;
    return fmt::format(
        "  Y: mean {:.4g} GPa, scatter {:.3g} GPa before; {:.4g}, {:.3g} after ({} in the mean)\n"
        "  beta: mean {:.4g}, scatter {:.3g} before; {:.4g}, {:.3g} after ({})\n"
        "  correlation of Y and beta: {:.2f} before, {:.2f} after\n",
        before.mean_modulus / pascals_per_gpa, before.modulus_scatter / pascals_per_gpa,
        after.mean_modulus / pascals_per_gpa, after.modulus_scatter / pascals_per_gpa,
        percent_text(after.mean_modulus / before.mean_modulus - 1.0), before.mean_damping,
        before.damping_scatter, after.mean_damping, after.damping_scatter,
        percent_text(after.mean_damping / before.mean_damping - 1.0), before.correlation,
        after.correlation);
}

/// One line for each stem that is unlike the others.
std::string remarkable_stems(const Laboratory& laboratory) {
    std::string text;
    for (const StemAnswer& stem : laboratory.stems) {
        std::vector<std::string> remarks;
        if (!stem.failure.empty())
            remarks.push_back("left out: " + stem.failure);
        if (stem.failure.empty() && stem.finding == diagnose::Finding::Inadequate)
            remarks.push_back(fmt::format("not explained: residual {:.2f} of the noise ({})",
                                          stem.after.over_noise, stem.tests));
        if (std::abs(stem.youngs_modulus_distance) > diagnose::outlier_distance)
            remarks.push_back(fmt::format("Y is {:.1f} deviations from the median",
                                          stem.youngs_modulus_distance));
        if (std::abs(stem.damping_distance) > diagnose::outlier_distance)
            remarks.push_back(
                fmt::format("beta is {:.1f} deviations from the median", stem.damping_distance));
        if (!remarks.empty())
            text += result_lines("  ", fmt::format("{}: {}", stem.name, fmt::join(remarks, "; ")));
    }
    return text;
}

std::string limit_sentence(const Laboratory& laboratory) {
    std::vector<std::string> limits;
    for (const diagnose::SharedLimit& limit : laboratory.shared_limits)
        if (std::isfinite(limit.of_all))
            limits.push_back(fmt::format("{} {} (one stem {:.2g})", limit.effect,
                                         with_unit(limit.of_all, limit.unit), limit.of_one));
    return limits.empty() ? ""
                          : wrapped("detection limits of all stems (3 sigma): ",
                                    fmt::format("{}", fmt::join(limits, ", ")), result_width - 42);
}

std::string stem_table(const Laboratory& laboratory) {
    std::string text = "\nstem          Y before      Y after (GPa)      beta before    beta after"
                       "      residual/noise  own effects\n";
    for (const StemAnswer& stem : laboratory.stems)
        text += stem.failure.empty()
                    ? fmt::format("{:<12} {:>9.4g}   {:>9.4g} ± {:<9.2g} {:>9.4g}   {:>9.4g} ± "
                                  "{:<9.2g} {:>5.2f} {:>5.2f}  {}\n",
                                  stem.name, stem.before.youngs_modulus / pascals_per_gpa,
                                  stem.after.youngs_modulus / pascals_per_gpa,
                                  reduce::normal_quantile_95 * stem.after.youngs_modulus_error /
                                      pascals_per_gpa,
                                  stem.before.damping, stem.after.damping,
                                  reduce::normal_quantile_95 * stem.after.damping_error,
                                  stem.before.over_noise, stem.after.over_noise,
                                  fmt::join(stem.own, ", "))
                    : fmt::format("{:<12} left out\n", stem.name);
    text += "\nmodels, log evidence over the best\n";
    for (const diagnose::ModelProbability& model : laboratory.posterior.models)
        if (std::isfinite(model.log_evidence) && model.failure.empty())
            text += fmt::format(
                "{:>10.1f}  {}\n", model.log_evidence,
                model.effects.empty()
                    ? "the published chain"
                    : fmt::format("{}", fmt::join(effect_names(model.effects, false), " + ")));
    return text;
}

json numbers_json(const diagnose::StemNumbers& numbers) {
    return {{"bond_youngs_modulus_pa", number(numbers.youngs_modulus)},
            {"bond_youngs_modulus_standard_error_pa", number(numbers.youngs_modulus_error)},
            {"bond_damping", number(numbers.damping)},
            {"bond_damping_standard_error", number(numbers.damping_error)},
            {"rms_mm", number(1e3 * numbers.rmse)}};
}

json population_json(const diagnose::Population& population) {
    return {{"mean_youngs_modulus_pa", number(population.mean_modulus)},
            {"youngs_modulus_standard_deviation_pa", number(population.modulus_scatter)},
            {"mean_damping", number(population.mean_damping)},
            {"damping_standard_deviation", number(population.damping_scatter)},
            {"correlation", number(population.correlation)}};
}

json stem_json(const StemAnswer& stem) {
    if (!stem.failure.empty())
        return {{"specimen", stem.name}, {"rig", stem.rig}, {"failure", stem.failure}};
    return {{"specimen", stem.name},
            {"rig", stem.rig},
            {"before", numbers_json(stem.before)},
            {"after", numbers_json(stem.after)},
            {"over_noise_before", number(stem.before.over_noise)},
            {"over_noise", number(stem.after.over_noise)},
            {"finding", std::string(to_string(stem.finding))},
            {"failed_tests", stem.tests},
            {"own_effects", stem.own},
            {"own_parameters", array_of(stem.own_values,
                                        [](const fit::FittedParameter& each) {
                                            return json{
                                                {"name", to_string(each.id)},
                                                {"value", number(each.value)},
                                                {"standard_error", number(each.standard_error)}};
                                        })},
            {"youngs_modulus_distance", number(stem.youngs_modulus_distance)},
            {"damping_distance", number(stem.damping_distance)}};
}

json effect_json(const diagnose::EffectAnswer& effect) {
    return {{"effect", effect.effect},
            {"rig", effect.rig},
            {"known", effect.is_known},
            {"probability", number(effect.probability)},
            {"family", effect.family},
            {"family_probability", number(effect.family_probability)},
            {"stems_needed", number(effect.stems_needed)},
            {"log_odds", number(effect.log_odds)},
            {"log_odds_per_stem", number(effect.log_odds_per_stem)},
            {"parameters", array_of(effect.values, [](const diagnose::SharedValue& value) {
                 return json{{"name", value.name},
                             {"unit", value.unit},
                             {"value", number(value.value)},
                             {"interval_95", bounds_json(value)}};
             })}};
}

json stem_effects_json(const std::vector<diagnose::EffectAnswer>& effects) {
    json out = json::array();
    for (const diagnose::EffectAnswer& each : effects)
        if (each.rig.empty() && !each.is_known)
            out.push_back({{"effect", each.effect},
                           {"probability", number(each.probability)},
                           {"family", each.family},
                           {"family_probability", number(each.family_probability)},
                           {"specimens", each.stems},
                           {"possible_specimens", each.possible_stems}});
    return out;
}

} // namespace

std::string rig_effects_text(std::span<const diagnose::EffectAnswer> effects) {
    std::string text;
    for (const diagnose::EffectAnswer& effect : effects)
        if (!effect.rig.empty())
            text += effect_lines(effect);
    return text;
}

json rig_effects_json(std::span<const diagnose::EffectAnswer> effects) {
    json out = json::array();
    for (const diagnose::EffectAnswer& effect : effects)
        if (!effect.rig.empty())
            out.push_back(effect_json(effect));
    return out;
}

json laboratory_json(const Laboratory& laboratory) {
    std::vector<std::string> sentences{diagnosis_headline(laboratory)};
    std::ranges::copy(explanation_sentences(laboratory), std::back_inserter(sentences));
    const auto limit_json = [](const diagnose::SharedLimit& limit) -> json {
        return {{"effect", limit.effect},           {"rig", limit.rig},
                {"parameter", limit.parameter},     {"unit", limit.unit},
                {"one_stem", number(limit.of_one)}, {"all_stems", number(limit.of_all)}};
    };
    json document = answer_json(laboratory);
    document.update(
        {{"format", "culm-laboratory"},
         {"version", 1},
         {"conclusion", to_string(laboratory.conclusion)},
         {"sentences", sentences},
         {"rig_effects", rig_effects_json(laboratory.answers)},
         {"stem_effects", stem_effects_json(laboratory.answers)},
         {"population",
          {{"before", population_json(laboratory.before)},
           {"after", population_json(laboratory.after)}}},
         {"stems", array_of(laboratory.stems, stem_json)},
         {"detection_limits", array_of(laboratory.shared_limits, limit_json)},
         {"largest_unvisited_log_evidence", laboratory.largest_unvisited
                                                ? number(laboratory.largest_unvisited->log_evidence)
                                                : json()}});
    return document;
}

std::string laboratory_text(const Laboratory& laboratory, bool with_details,
                            const TextStyle& style) {
    std::string text =
        header(laboratory) + style.headline(result_lines("", diagnosis_headline(laboratory)));
    for (const std::string& sentence : explanation_sentences(laboratory))
        text += result_lines("  ", sentence);
    for (const diagnose::EffectAnswer& each : laboratory.answers)
        text += effect_lines(each);
    text += population_lines(laboratory) + remarkable_stems(laboratory) + "\n" +
            limit_sentence(laboratory);
    return with_details ? text + stem_table(laboratory) : text;
}

} // namespace culm::present
