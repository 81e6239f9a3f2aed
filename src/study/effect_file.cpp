// SPDX-License-Identifier: BSD-3-Clause
#include "study/effect_file.hpp"

#include "core/error.hpp"
#include "core/file_text.hpp"
#include "core/nearest_name.hpp"
#include "measure/toml_table.hpp"
#include "physics/effects/user_effect.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::study {

namespace {

using measure::FileFaults;
using measure::TomlTable;

constexpr measure::NumberRange any_number{-1e300, 1e300};
constexpr std::size_t most_parameters = 20;

/// A table that is there; an absent one is an empty one.
const toml::table& table_in(const toml::table& root, std::string_view key, FileFaults& faults) {
    static const toml::table empty;
    const toml::node* node = root.get(key);
    if (node == nullptr)
        return empty;
    if (const toml::table* table = node->as_table())
        return *table;
    faults.add(node->source().begin.line, fmt::format("{0} must be a table: write [{0}]", key));
    return empty;
}

void refuse_other_keys(const toml::table& table, const std::string& prefix,
                       std::span<const std::string> valid, FileFaults& faults) {
    for (const auto& [key, node] : table) {
        if (std::ranges::find(valid, key.str()) != valid.end())
            continue;
        const std::string nearest = core::nearest_name(key.str(), valid);
        faults.add(key.source().begin.line,
                   fmt::format("{}{}: unknown key{}; allowed: {}", prefix, key.str(),
                               nearest.empty() ? "" : fmt::format(" (did you mean {}?)", nearest),
                               fmt::join(valid, ", ")));
    }
}

std::vector<std::string> effect_keys() {
    return {"name", "summary", "kind", "expression", "source", "signature", "remedy", "energy"};
}

std::vector<std::string> parameter_keys() {
    return {"default", "lower", "upper", "scale", "unit", "logarithmic", "calibrated", "meaning"};
}

/// What goes together: the bounds around the default, a scale, logarithms of positive numbers.
void check_parameter(const TomlTable& table, const physics::EffectParameter& parameter) {
    if (!(parameter.lower < parameter.upper))
        table.fault("upper", fmt::format("must be above lower = {}", parameter.lower));
    else if (parameter.default_value < parameter.lower || parameter.default_value > parameter.upper)
        table.fault("default",
                    fmt::format("must lie from {} to {}", parameter.lower, parameter.upper));
    if (!(parameter.scale > 0.0))
        table.fault("scale", "must be above 0: a typical size of the parameter");
    if (parameter.fitted_as == physics::FittedAs::Logarithm && !(parameter.lower > 0.0))
        table.fault("lower", "must be above 0 for a logarithmic parameter");
}

physics::EffectParameter read_parameter(const toml::table& content, const std::string& name,
                                        FileFaults& faults) {
    TomlTable table(&content, "parameters." + name, faults);
    refuse_other_keys(content, "parameters." + name + ".", parameter_keys(), faults);
    const std::size_t before = faults.count();
    table.missing("default", "the value to start from");
    table.missing("lower", "the least value that makes sense");
    table.missing("upper", "the largest value that makes sense");
    physics::EffectParameter parameter;
    parameter.name = name;
    parameter.default_value = table.number("default", any_number).value_or(0.0);
    parameter.lower = table.number("lower", any_number).value_or(0.0);
    parameter.upper = table.number("upper", any_number).value_or(0.0);
    const double size = std::abs(parameter.default_value);
    parameter.scale = table.number("scale", any_number)
                          .value_or(size > 0.0 ? size : 0.1 * (parameter.upper - parameter.lower));
    parameter.unit = table.has("unit") ? table.text("unit").value_or("") : "";
    parameter.meaning = table.text("meaning").value_or("of the formula");
    if (table.flag("logarithmic").value_or(false))
        parameter.fitted_as = physics::FittedAs::Logarithm;
    parameter.calibrated = table.flag("calibrated").value_or(true);
    if (faults.count() == before)
        check_parameter(table, parameter);
    return parameter;
}

/// In the order of the file; toml++ sorts by name.
std::vector<physics::EffectParameter>
read_parameters(const toml::table& root, physics::UserLawKind kind, FileFaults& faults) {
    struct Entry {
        std::size_t line;
        physics::EffectParameter parameter;
    };
    std::vector<Entry> entries;
    for (const auto& [key, node] : table_in(root, "parameters", faults)) {
        const std::size_t line = key.source().begin.line;
        const std::string name(key.str());
        if (const std::string fault = physics::parameter_name_fault(name, kind); !fault.empty())
            faults.add(line, fmt::format("parameters.{}: {}", name, fault));
        else if (const toml::table* content = node.as_table())
            entries.push_back({line, read_parameter(*content, name, faults)});
        else
            faults.add(line,
                       fmt::format("parameters.{0} must be a table: write [parameters.{0}]", name));
    }
    if (entries.size() > most_parameters)
        faults.add(entries.back().line, fmt::format("parameters: {} of them; {} are allowed",
                                                    entries.size(), most_parameters));
    std::ranges::sort(entries, {}, &Entry::line);
    std::vector<physics::EffectParameter> parameters;
    parameters.reserve(entries.size());
    for (Entry& entry : entries)
        parameters.push_back(std::move(entry.parameter));
    return parameters;
}

physics::UserEffectText read_text(TomlTable& table, FileFaults& faults) {
    table.missing("name", "what the effect is called, in lower-case letters");
    table.missing("kind", "what the formula gives");
    table.missing("expression", "the formula");
    physics::UserEffectText text;
    text.name = table.text("name").value_or("");
    if (const std::string fault = physics::effect_name_fault(text.name);
        !text.name.empty() && !fault.empty())
        table.fault("name", fault);
    const std::vector<std::string> kinds = physics::user_law_kind_names();
    if (const auto kind = table.word("kind", kinds))
        text.kind = physics::user_law_kind(kinds[*kind]).value_or(text.kind);
    text.formula = table.text("expression").value_or("");
    text.summary = table.text("summary").value_or("defined in " + faults.file());
    text.source = table.text("source").value_or(faults.file());
    text.signature = table.text("signature").value_or("not described by its author");
    text.remedy = table.text("remedy").value_or("not described by its author");
    text.energy = table.text("energy").value_or("not described by its author");
    return text;
}

} // namespace

physics::EffectPointer read_effect_file(const std::filesystem::path& file) {
    return read_effect_text(core::file_text(file), file.string());
}

physics::EffectPointer read_effect_text(const std::string& source, const std::string& file) {
    const toml::table root = measure::parse_toml_text(source, file);
    FileFaults faults(file);
    refuse_other_keys(root, "", std::vector<std::string>{"effect", "parameters"}, faults);
    if (!root.contains("effect"))
        faults.add(0, "[effect] is missing: a table with name, kind and expression");
    const toml::table& content = table_in(root, "effect", faults);
    refuse_other_keys(content, "effect.", effect_keys(), faults);
    TomlTable table(&content, "effect", faults);
    physics::UserEffectText text;
    if (root.contains("effect"))
        text = read_text(table, faults);
    text.parameters = read_parameters(root, text.kind, faults);
    faults.throw_if_any();
    const std::size_t line = table.line("expression");
    try {
        return physics::make_user_effect(std::move(text));
    } catch (const core::InputError& error) {
        faults.add(line, fmt::format("effect.expression: {}", error.what()));
    }
    faults.throw_if_any();
    return nullptr;
}

std::vector<physics::SelectedEffect> effects_from(std::string_view text) {
    return physics::parse_effects(text,
                                  [](const std::string& file) { return read_effect_file(file); });
}

} // namespace culm::study
