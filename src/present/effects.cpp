// SPDX-License-Identifier: BSD-3-Clause
#include "present/effects.hpp"

#include "present/text.hpp"

#include <algorithm>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::present {
namespace {

using physics::EffectParameter;

constexpr std::size_t label_width = 12;

/// A label, then the text in lines that begin below its first word.
std::string labelled(const std::string& label, const std::string& text) {
    return wrapped(fmt::format("{:<{}}", label, label_width), text, text_width);
}

std::string unit_of(const EffectParameter& parameter) {
    return parameter.unit.empty() ? "" : " " + parameter.unit;
}

std::string how_fitted(const EffectParameter& parameter) {
    if (!parameter.calibrated)
        return "known, not fitted";
    if (parameter.fitted_as == physics::FittedAs::Itself)
        return "fitted";
    return fmt::format("fitted {}", physics::to_string(parameter.fitted_as));
}

std::string parameter_text(const EffectParameter& parameter) {
    return fmt::format("{} = {}{} ({} to {}; {})\n{}", parameter.name, parameter.default_value,
                       unit_of(parameter), parameter.lower, parameter.upper, how_fitted(parameter),
                       labelled("", parameter.meaning));
}

std::string markdown_parameters(const physics::Effect& effect) {
    std::string out = "\n| parameter | unit | default | from | to | in a fit | meaning |\n"
                      "|---|---|---|---|---|---|---|\n";
    for (const EffectParameter& parameter : effect.parameters())
        out +=
            fmt::format("| `{}` | {} | {} | {} | {} | {} | {} |\n", parameter.name,
                        parameter.unit.empty() ? "1" : parameter.unit, parameter.default_value,
                        parameter.lower, parameter.upper, how_fitted(parameter), parameter.meaning);
    return out;
}

nlohmann::json parameter_json(const EffectParameter& parameter) {
    return {{"name", parameter.name},
            {"unit", parameter.unit},
            {"meaning", parameter.meaning},
            {"default", parameter.default_value},
            {"lower", parameter.lower},
            {"upper", parameter.upper},
            {"scale", parameter.scale},
            {"fitted_as", physics::to_string(parameter.fitted_as)},
            {"calibrated", parameter.calibrated}};
}

} // namespace

std::string effects_list(std::span<const physics::EffectPointer> effects) {
    std::size_t width = 0;
    for (const physics::EffectPointer& effect : effects)
        width = std::max(width, effect->name().size());
    std::string out;
    for (const physics::EffectPointer& effect : effects) {
        std::vector<std::string> names;
        for (const EffectParameter& parameter : effect->parameters())
            names.push_back(parameter.name);
        out += fmt::format("{:<{}}  {} [{}]\n", effect->name(), width, effect->summary(),
                           fmt::join(names, ", "));
    }
    return out;
}

std::string effect_card(const physics::Effect& effect) {
    std::string out = fmt::format("{}: {}\n\n", effect.name(), effect.summary());
    if (effect.family() != physics::Family::Own)
        out += labelled("family", std::string(physics::to_string(effect.family())));
    out += labelled("law", effect.law());
    out += labelled("source", effect.source());
    out += labelled("signature", effect.signature());
    out += labelled("remedy", effect.remedy());
    out += labelled("energy", effect.energy());
    if (effect.dimensions() == 3)
        out += labelled("needs", "three dimensions");
    if (!effect.excludes().empty())
        out += labelled("contains", fmt::format("{}, which cannot be added as well",
                                                fmt::join(effect.excludes(), ", ")));
    for (const EffectParameter& parameter : effect.parameters())
        out += '\n' + parameter_text(parameter);
    return out;
}

std::string effects_markdown(std::span<const physics::EffectPointer> effects) {
    std::string out;
    for (const physics::EffectPointer& effect : effects) {
        out +=
            fmt::format("{}### `{}`\n{}.\n\n* Family: {}.\n* Law: {}.\n* Source: {}.\n* Signature: "
                        "{}.\n* Remedy: {}.\n* Energy: {}.\n",
                        out.empty() ? "" : "\n", effect->name(), effect->summary(),
                        physics::to_string(effect->family()), effect->law(), effect->source(),
                        effect->signature(), effect->remedy(), effect->energy());
        if (effect->dimensions() == 3)
            out += "* Needs three dimensions.\n";
        if (!effect->excludes().empty())
            out += fmt::format("* Contains {}, which cannot be added as well.\n",
                               fmt::join(effect->excludes(), ", "));
        out += markdown_parameters(*effect);
    }
    return out;
}

nlohmann::json effects_json(std::span<const physics::EffectPointer> effects) {
    nlohmann::json cards = nlohmann::json::array();
    for (const physics::EffectPointer& effect : effects) {
        nlohmann::json parameters = nlohmann::json::array();
        for (const EffectParameter& parameter : effect->parameters())
            parameters.push_back(parameter_json(parameter));
        cards.push_back({{"name", effect->name()},
                         {"family", physics::to_string(effect->family())},
                         {"summary", effect->summary()},
                         {"law", effect->law()},
                         {"source", effect->source()},
                         {"signature", effect->signature()},
                         {"remedy", effect->remedy()},
                         {"energy", effect->energy()},
                         {"dimensions", effect->dimensions()},
                         {"excludes", effect->excludes()},
                         {"parameters", parameters}});
    }
    return {{"format", "culm-effects"}, {"version", 1}, {"effects", cards}};
}

} // namespace culm::present
