// SPDX-License-Identifier: BSD-3-Clause
#include "present/laboratory.hpp"

#include "present/answer_json.hpp"
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
    const auto line = [](const char* name, const char* unit, const reduce::SampleSummary& was,
                         const reduce::SampleSummary& is, double scale) {
        return fmt::format("  {}: mean {:.4g}{}, scatter {:.3g}{} before; {:.4g}, {:.3g} after ({} "
                           "in the mean)\n",
                           name, was.mean / scale, unit, was.standard_deviation / scale, unit,
                           is.mean / scale, is.standard_deviation / scale,
                           percent_text(is.mean / was.mean - 1.0));
    };
    return line("Y", " GPa", before.bond_youngs_modulus, after.bond_youngs_modulus,
                pascals_per_gpa) +
           line("beta", "", before.bond_damping, after.bond_damping, 1.0) +
           fmt::format("  correlation of Y and beta: {:.2f} before, {:.2f} after\n",
                       before.correlation, after.correlation);
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
    for (const diagnose::DetectionLimit& limit : laboratory.detection_limits)
        if (std::isfinite(limit.value))
            limits.push_back(fmt::format("{} {} (one stem {:.2g})", limit.effect,
                                         with_unit(limit.value, limit.unit), limit.of_one));
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

template <class To>
void describe_stem(To& to, const StemAnswer& stem) {
    to("specimen", stem.name);
    to("rig", stem.rig);
    to.when(!stem.failure.empty(), [&] { to("failure", stem.failure); });
    to.when(stem.failure.empty(), [&] {
        to("before", stem.before, "of the published chain");
        to("after", stem.after, "with the effects");
        to("over_noise_before", stem.before.over_noise);
        to("over_noise", stem.after.over_noise);
        to("finding", [&] { return to_string(stem.finding); });
        to("failed_tests", stem.tests);
        to("own_effects", stem.own);
        to.list("own_parameters", stem.own_values, [&](const fit::FittedParameter& each) {
            to("name", [&] { return to_string(each.id); });
            to("value", each.value);
            to("standard_error", each.standard_error);
        });
        to("youngs_modulus_distance", stem.youngs_modulus_distance,
           "from the median, in robust standard deviations");
        to("damping_distance", stem.damping_distance);
    });
}

/// Effects of stems, which are not known.
std::vector<diagnose::EffectAnswer> stem_effects_of(const Laboratory& laboratory) {
    std::vector<diagnose::EffectAnswer> effects = laboratory.answers;
    std::erase_if(effects, [](const auto& each) { return !each.rig.empty() || each.is_known; });
    return effects;
}

/// laboratory.json.
struct LaboratoryFile {
    core::Viewed<DiagnosisReport> report;
};
template <class To>
void describe(To& to, const LaboratoryFile& file) {
    const Laboratory& laboratory = *file.report->found;
    to.constant("format", "culm-laboratory");
    to.constant("version", 1);
    describe_answer(to, laboratory);
    to(
        "conclusion", [&] { return to_string(laboratory.conclusion); },
        "adequate, effect, tie or unknown");
    to("sentences", [&] {
        std::vector<std::string> sentences{diagnosis_headline(laboratory)};
        std::ranges::copy(explanation_sentences(laboratory), std::back_inserter(sentences));
        return sentences;
    });
    describe_rig_effects(to, "rig_effects", laboratory.answers);
    to.list(
        "stem_effects", [&] { return stem_effects_of(laboratory); },
        [&](const diagnose::EffectAnswer& each) {
            to("effect", each.effect);
            to("probability", each.probability);
            to("family", each.family);
            to("family_probability", each.family_probability);
            to("specimens", each.stems);
            to("possible_specimens", each.possible_stems);
        });
    to.object("population", [&] {
        to("before", laboratory.before);
        to("after", laboratory.after);
    });
    to.list("stems", laboratory.stems, [&](const StemAnswer& stem) { describe_stem(to, stem); });
    to.list("detection_limits", laboratory.detection_limits,
            [&](const diagnose::DetectionLimit& limit) {
                to("effect", limit.effect);
                to("rig", limit.rig);
                to("parameter", limit.parameter);
                to("unit", limit.unit);
                to("one_stem", limit.of_one);
                to("all_stems", limit.value);
            });
    to("largest_unvisited_log_evidence", [&] {
        return laboratory.largest_unvisited
                   ? std::optional(laboratory.largest_unvisited->log_evidence)
                   : std::nullopt;
    });
    to("folders", file.report->folders);
    to("options", *file.report->options);
    to("provenance", file.report->provenance);
}

} // namespace

std::string rig_effects_text(std::span<const diagnose::EffectAnswer> effects) {
    std::string text;
    for (const diagnose::EffectAnswer& effect : effects)
        if (!effect.rig.empty())
            text += effect_lines(effect);
    return text;
}

json laboratory_json(const DiagnosisReport& report) {
    return core::json_of(LaboratoryFile{report});
}

json laboratory_schema() {
    return core::schema_of<LaboratoryFile>();
}

std::string laboratory_text(const Laboratory& laboratory, bool with_details) {
    std::string text = header(laboratory) + result_lines("", diagnosis_headline(laboratory));
    for (const std::string& sentence : explanation_sentences(laboratory))
        text += result_lines("  ", sentence);
    for (const diagnose::EffectAnswer& each : laboratory.answers)
        text += effect_lines(each);
    text += population_lines(laboratory) + remarkable_stems(laboratory) + "\n" +
            limit_sentence(laboratory);
    return with_details ? text + stem_table(laboratory) : text;
}

} // namespace culm::present
