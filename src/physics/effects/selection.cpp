// SPDX-License-Identifier: BSD-3-Clause
#include "physics/effects/selection.hpp"

#include "core/error.hpp"
#include "core/nearest_name.hpp"
#include "physics/effects/library.hpp"

#include <charconv>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::physics {

namespace {

std::string_view trimmed(std::string_view text) {
    constexpr std::string_view blanks = " \t\n";
    const std::size_t first = text.find_first_not_of(blanks);
    if (first == std::string_view::npos)
        return {};
    return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

/// Parts of `text` between commas outside parentheses, trimmed.
std::vector<std::string_view> split(std::string_view text) {
    std::vector<std::string_view> parts;
    int depth = 0;
    std::size_t start = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
        depth += text[i] == '(' ? 1 : text[i] == ')' ? -1 : 0;
        if (text[i] == ',' && depth <= 0) {
            parts.push_back(trimmed(text.substr(start, i - start)));
            start = i + 1;
        }
    }
    parts.push_back(trimmed(text.substr(start)));
    return parts;
}

[[noreturn]] void refuse(std::string_view text, std::string_view why) {
    throw core::InputError(fmt::format(
        "effect \"{}\": {}; write for example quadratic_drag(drag_coefficient=1.2)", text, why));
}

std::size_t parameter_index(const Effect& effect, std::string_view name) {
    std::vector<std::string> names;
    for (const EffectParameter& parameter : effect.parameters)
        names.push_back(parameter.name);
    for (std::size_t k = 0; k < names.size(); ++k)
        if (names[k] == name)
            return k;
    throw core::InputError(fmt::format("{} has no parameter \"{}\"{}; it has {}", effect.name, name,
                                       core::did_you_mean(name, names), fmt::join(names, ", ")));
}

double number(std::string_view text, std::string_view whole) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size())
        refuse(whole, fmt::format("\"{}\" is not a number", text));
    return value;
}

/// `assignments` is the text between the parentheses.
void fix_values(std::string_view assignments, std::string_view whole, SelectedEffect& selected) {
    for (const std::string_view part : split(assignments)) {
        const std::size_t equals = part.find('=');
        if (equals == std::string_view::npos)
            refuse(whole, fmt::format("\"{}\" is not parameter=value", part));
        const std::size_t k = parameter_index(*selected.effect, trimmed(part.substr(0, equals)));
        const EffectParameter& parameter = selected.effect->parameters[k];
        if (selected.fixed[k])
            refuse(whole, fmt::format("{} is given twice", parameter.name));
        selected.fixed[k] = number(trimmed(part.substr(equals + 1)), whole);
        if (const std::string fault = value_fault(*selected.effect, parameter, *selected.fixed[k]);
            !fault.empty())
            throw core::InputError(fault);
    }
}

} // namespace

bool is_effect_file(std::string_view name) {
    return name.ends_with(".toml") || name.find('/') != std::string_view::npos;
}

SelectedEffect parse_effect(std::string_view text, const EffectFileReader& read) {
    const std::string_view whole = trimmed(text);
    const std::size_t open = whole.find('(');
    const std::string_view name = trimmed(whole.substr(0, open));
    if (name.empty())
        refuse(whole, "no name");
    SelectedEffect selected;
    selected.effect = is_effect_file(name) ? read(std::string(name)) : effect_named(name);
    selected.fixed.resize(selected.effect->parameters.size());
    if (open == std::string_view::npos)
        return selected;
    if (whole.back() != ')')
        refuse(whole, "must end with the closing parenthesis");
    const std::string_view assignments = trimmed(whole.substr(open + 1, whole.size() - open - 2));
    if (!assignments.empty())
        fix_values(assignments, whole, selected);
    return selected;
}

std::vector<SelectedEffect> parse_alternatives(std::string_view text,
                                               const EffectFileReader& read) {
    std::vector<SelectedEffect> effects;
    if (trimmed(text).empty())
        return effects;
    for (const std::string_view part : split(text))
        effects.push_back(parse_effect(part, read));
    return effects;
}

std::vector<SelectedEffect> parse_effects(std::string_view text, const EffectFileReader& read) {
    std::vector<SelectedEffect> effects = parse_alternatives(text, read);
    std::vector<EffectPointer> pointers;
    for (const SelectedEffect& selected : effects)
        pointers.push_back(selected.effect);
    check_combination(pointers);
    return effects;
}

std::string to_string(const SelectedEffect& selected) {
    const std::vector<EffectParameter>& parameters = selected.effect->parameters;
    std::vector<std::string> fixed;
    for (std::size_t k = 0; k < parameters.size(); ++k)
        if (selected.fixed[k])
            fixed.push_back(fmt::format("{}={}", parameters[k].name, *selected.fixed[k]));
    if (fixed.empty())
        return selected.effect->name;
    return fmt::format("{}({})", selected.effect->name, fmt::join(fixed, ","));
}

ActiveEffect with_defaults(const SelectedEffect& selected, const StemParameters<double>& stem) {
    ActiveEffect active{selected.effect, {}};
    const std::vector<EffectParameter> parameters = selected.effect->parameters_for(stem);
    for (std::size_t k = 0; k < parameters.size(); ++k)
        active.values.push_back(selected.fixed[k].value_or(parameters[k].default_value));
    return active;
}

} // namespace culm::physics
