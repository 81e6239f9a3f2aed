// SPDX-License-Identifier: BSD-3-Clause
#include "study/config/study_effects.hpp"

#include "core/error.hpp"
#include "core/toml/table.hpp"
#include "core/user_files.hpp"
#include "physics/effects/user_effect.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace culm::study {

namespace {

using core::FileFaults;
using core::TomlTable;

constexpr core::Interval any_effect_value{-1e300, 1e300};
constexpr std::size_t most_parameters = 20;

/// Checks that default, bounds, scale and a logarithm are consistent.
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

physics::EffectParameter read_parameter(const TomlTable& table, const std::string& name,
                                        const FileFaults& faults) {
    const std::size_t before = faults.count();
    table.missing("default", "the value to start from");
    table.missing("lower", "the least value that makes sense");
    table.missing("upper", "the largest value that makes sense");
    physics::EffectParameter parameter;
    parameter.name = name;
    parameter.default_value = table.number("default", any_effect_value).value_or(0.0);
    parameter.lower = table.number("lower", any_effect_value).value_or(0.0);
    parameter.upper = table.number("upper", any_effect_value).value_or(0.0);
    const double size = std::abs(parameter.default_value);
    parameter.scale = table.number("scale", any_effect_value)
                          .value_or(size > 0.0 ? size : 0.1 * (parameter.upper - parameter.lower));
    parameter.unit = table.has("unit") ? table.text("unit").value_or("") : "";
    parameter.meaning = table.text("meaning").value_or("of the formula");
    if (table.flag("logarithmic").value_or(false))
        parameter.fitted_as = physics::FittedAs::Logarithm;
    parameter.calibrated = table.flag("calibrated").value_or(true);
    // Otherwise the defaults of numbers that could not be read would be compared here.
    if (faults.count() == before)
        check_parameter(table, parameter);
    return parameter;
}

/// In the order of the file.
std::vector<physics::EffectParameter>
read_parameters(const TomlTable& table, physics::UserLawKind kind, FileFaults& faults) {
    const std::vector<std::string> names = table.keys();
    if (names.size() > most_parameters)
        faults.add(table.line(names.back()), fmt::format("parameters: {} of them; {} are allowed",
                                                         names.size(), most_parameters));
    std::vector<physics::EffectParameter> parameters;
    for (std::size_t i = 0; i < std::min(names.size(), most_parameters); ++i) {
        const TomlTable content = table.table(names[i]);
        if (const std::string fault = physics::parameter_name_fault(names[i], kind); !fault.empty())
            faults.add(table.line(names[i]), fmt::format("parameters.{}: {}", names[i], fault));
        else if (content.exists())
            parameters.push_back(read_parameter(content, names[i], faults));
    }
    return parameters;
}

physics::UserEffectText read_text(const TomlTable& table, const FileFaults& faults) {
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

std::shared_ptr<const EffectParameterRow> row_of(const physics::Effect& effect,
                                                 const physics::EffectParameter& parameter,
                                                 EffectPlace place) {
    // Shared and never moved: Parameter refers to the texts of its row, factors to the Parameter.
    auto row = std::make_shared<EffectParameterRow>();
    row->key = effect.name + "." + parameter.name;
    row->unit = parameter.unit;
    row->meaning = parameter.meaning;
    row->parameter.key = row->key;
    row->parameter.section = "effects";
    row->parameter.unit = {row->unit, "", core::Dimension::None};
    row->parameter.range = {parameter.lower, parameter.upper};
    row->parameter.meaning = row->meaning;
    row->parameter.effect = place;
    return row;
}

} // namespace

physics::EffectPointer read_effect_file(const std::filesystem::path& file) {
    return read_effect_text(core::file_text(file), file.string());
}

physics::EffectPointer read_effect_text(const std::string& source, const std::string& file) {
    core::TomlDocument document(source, file);
    FileFaults& faults = document.faults();
    const TomlTable& root = document.root();
    root.missing("effect", "a table [effect] with name, kind and expression");
    const TomlTable table = root.table("effect");
    physics::UserEffectText text = read_text(table, faults);
    text.parameters = read_parameters(root.table("parameters"), text.kind, faults);
    document.finish();
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

StudyEffects::StudyEffects(std::vector<physics::SelectedEffect> selected)
    : selected_(std::move(selected)) {
    for (std::size_t effect = 0; effect < selected_.size(); ++effect) {
        const auto& parameters = selected_[effect].effect->parameters;
        for (std::size_t value = 0; value < parameters.size(); ++value)
            rows_.push_back(row_of(*selected_[effect].effect, parameters[value], {effect, value}));
    }
}

const Parameter* StudyEffects::find(std::string_view key) const {
    const auto found =
        std::ranges::find_if(rows_, [key](const auto& row) { return row->key == key; });
    return found == rows_.end() ? nullptr : &(*found)->parameter;
}

std::vector<physics::ActiveEffect>
StudyEffects::with_defaults(const physics::StemParameters<double>& stem) const {
    std::vector<physics::ActiveEffect> active;
    for (const physics::SelectedEffect& selected : selected_)
        active.push_back(physics::with_defaults(selected, stem));
    return active;
}

} // namespace culm::study
