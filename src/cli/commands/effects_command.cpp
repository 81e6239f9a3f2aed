// SPDX-License-Identifier: BSD-3-Clause
// culm effects [NAME...]
#include "cli/options.hpp"
#include "physics/effects/library.hpp"
#include "present/files.hpp"
#include "present/text.hpp"
#include "study/config/study_effects.hpp"

#include <algorithm>
#include <ranges>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

namespace culm::cli {
namespace {

using physics::EffectParameter;

/// A label, then the text in lines that begin below its first word.
std::string labelled(const std::string& label, const std::string& text) {
    return present::wrapped(fmt::format("{:<12}", label), text, present::text_width);
}

std::string how_fitted(const EffectParameter& parameter) {
    if (!parameter.calibrated)
        return "known, not fitted";
    if (parameter.fitted_as == physics::FittedAs::Itself)
        return "fitted";
    return fmt::format("fitted {}", physics::to_string(parameter.fitted_as));
}

std::string parameter_text(const EffectParameter& parameter) {
    return fmt::format("{} = {}{}{} ({} to {}; {})\n{}", parameter.name, parameter.default_value,
                       parameter.unit.empty() ? "" : " ", parameter.unit, parameter.lower,
                       parameter.upper, how_fitted(parameter), labelled("", parameter.meaning));
}

/// What `culm effects --json` writes.
struct EffectsFile {
    std::vector<physics::EffectCard> effects;
};
template <class To>
void describe(To& to, const EffectsFile& file) {
    to.constant("format", "culm-effects");
    to.constant("version", 1);
    to.list("effects", file.effects, [&](const physics::EffectCard& effect) {
        to("name", effect.name);
        to("family", [&] { return physics::to_string(effect.family); });
        to("summary", effect.summary);
        to("law", effect.law);
        to("source", effect.source);
        to("signature", effect.signature, "what it does to a recording");
        to("remedy", effect.remedy);
        to("energy", effect.energy);
        to("dimensions", effect.dimensions);
        to("excludes", effect.excludes);
        to.list("parameters", effect.parameters, [&](const EffectParameter& parameter) {
            to("name", parameter.name);
            to("unit", parameter.unit);
            to("meaning", parameter.meaning);
            to("default", parameter.default_value);
            to("lower", parameter.lower);
            to("upper", parameter.upper);
            to("scale", parameter.scale, "a typical size");
            to("fitted_as", [&] { return physics::to_string(parameter.fitted_as); });
            to("calibrated", parameter.calibrated);
        });
    });
}

/// One line for each effect, with the names of its parameters.
std::string effects_list(std::span<const physics::EffectPointer> effects) {
    std::size_t width = 0;
    for (const physics::EffectPointer& effect : effects)
        width = std::max(width, effect->name.size());
    std::string out;
    for (const physics::EffectPointer& effect : effects)
        out += fmt::format(
            "{:<{}}  {} [{}]\n", effect->name, width, effect->summary,
            fmt::join(effect->parameters | std::views::transform(&EffectParameter::name), ", "));
    return out;
}

/// All properties of one effect, in lines of some 90 characters.
std::string effect_card(const physics::Effect& effect) {
    std::string out = fmt::format("{}: {}\n\n", effect.name, effect.summary);
    if (effect.family != physics::Family::Own)
        out += labelled("family", std::string(physics::to_string(effect.family)));
    out += labelled("law", effect.law);
    out += labelled("source", effect.source);
    out += labelled("signature", effect.signature);
    out += labelled("remedy", effect.remedy);
    out += labelled("energy", effect.energy);
    if (effect.dimensions == 3)
        out += labelled("needs", "three dimensions");
    if (!effect.excludes.empty())
        out += labelled("contains", fmt::format("{}, which cannot be added as well",
                                                fmt::join(effect.excludes, ", ")));
    for (const EffectParameter& parameter : effect.parameters)
        out += '\n' + parameter_text(parameter);
    return out;
}

struct EffectsArguments {
    std::vector<std::string> names;
    std::string json;
};

std::vector<physics::EffectPointer> chosen(const EffectsArguments& arguments) {
    if (arguments.names.empty())
        return physics::all_effects();
    std::vector<physics::EffectPointer> effects;
    for (const std::string& name : arguments.names)
        effects.push_back(physics::is_effect_file(name) ? study::read_effect_file(name)
                                                        : physics::effect_named(name));
    return effects;
}

void show(const EffectsArguments& arguments) {
    const std::vector<physics::EffectPointer> effects = chosen(arguments);
    if (!arguments.json.empty()) {
        EffectsFile file;
        for (const physics::EffectPointer& effect : effects)
            file.effects.push_back(*effect);
        present::write_json(arguments.json, core::json_of(file));
        return;
    }
    if (arguments.names.empty()) {
        fmt::print("{}\n`culm effects NAME` shows the law, the signature, the remedy, and the "
                   "parameters.\n",
                   effects_list(effects));
        return;
    }
    for (std::size_t i = 0; i < effects.size(); ++i)
        fmt::print("{}{}", i == 0 ? "" : "\n", effect_card(*effects[i]));
}

} // namespace

nlohmann::json effects_schema() {
    return core::schema_of<EffectsFile>();
}

void add_effects_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand(
        "effects", "The physical effects that can be added to the model, and their signatures");
    auto arguments = std::make_shared<EffectsArguments>();
    add_option(*command, "names", arguments->names, "NAME",
               "Effects to describe, or TOML files that define one (default: list all)");
    add_option(*command, "--json", arguments->json, "FILE",
               "Write them to this file (- for stdout)");
    command->callback([arguments] { show(*arguments); });
}

} // namespace culm::cli
