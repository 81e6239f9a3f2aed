// SPDX-License-Identifier: BSD-3-Clause
// Factors that take levels: lists, ranges, the points of a list.
#include "study/config/keys.hpp"
#include "study/config/sections.hpp"
#include "study/design/design.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <fmt/format.h>

namespace culm::study {

std::string parameter_allowed(const Parameter& parameter) {
    return "must be " + description_of(parameter).allowed();
}

namespace {

/// The value in SI if the node is a number that the parameter allows.
std::optional<double> parameter_value(const toml::node& node, const Parameter& parameter) {
    const bool right_type = parameter.is_whole_number ? node.is_integer() : node.is_number();
    const auto value = node.value<double>();
    if (right_type && value && parameter.range.contains(*value))
        return parameter.unit.to_si(*value);
    return std::nullopt;
}

/// The factor, or nothing with the error recorded: levels must be whole for whole-number
/// parameters, and each must occur once.
std::optional<Factor> factor_of(Levels levels, const core::TomlEntry& entry,
                                const Parameter& parameter, const ConfigContext& context) {
    if (parameter.is_whole_number &&
        std::ranges::any_of(levels, [](double v) { return v != std::round(v); })) {
        context.fault("factors", entry, "levels must be whole numbers");
        return std::nullopt;
    }
    Levels sorted = levels;
    // Two equal levels would make points that are the same case under two numbers.
    std::ranges::sort(sorted);
    if (const auto twice = std::ranges::adjacent_find(sorted); twice != sorted.end()) {
        context.fault("factors", entry,
                      fmt::format("must name {} once only", config_text(parameter, *twice)));
        return std::nullopt;
    }
    return Factor{&parameter, std::move(levels)};
}

std::optional<Factor> read_levels(const toml::array& array, const core::TomlEntry& entry,
                                  const Parameter& parameter, const ConfigContext& context) {
    Levels levels;
    for (const toml::node& node : array) {
        const auto value = parameter_value(node, parameter);
        if (!value) {
            context.errors.add(core::line_of(node), "factors." + entry.key, core::value_text(node),
                               parameter_allowed(parameter));
            return std::nullopt;
        }
        levels.push_back(*value);
    }
    if (levels.empty()) {
        context.fault("factors", entry, "must name at least one value");
        return std::nullopt;
    }
    return factor_of(std::move(levels), entry, parameter, context);
}

/// `count` levels from `from` to `to`, both exactly; in the unit of the arguments.
Levels spaced(double from, double to, std::int64_t count, bool is_log) {
    Levels levels;
    for (std::int64_t i = 0; i < count; ++i) {
        const double t = static_cast<double>(i) / static_cast<double>(count - 1);
        // Multiplying before dividing keeps whole levels whole.
        const double linear =
            from + (to - from) * static_cast<double>(i) / static_cast<double>(count - 1);
        levels.push_back(is_log ? from * std::pow(to / from, t) : linear);
    }
    levels.back() = to;
    return levels;
}

/// Number of levels from `step` or `count`; nothing (with the error recorded) if they are wrong.
std::optional<std::int64_t> level_count(const FactorReader& factor, double from, double to) {
    if (factor.table.has("count"))
        return factor.entry.count;
    if (!factor.entry.step)
        return std::nullopt;
    const double intervals = (to - from) / *factor.entry.step;
    constexpr double most_intervals = 1e6;
    // Decimal inputs cause a relative error of about 1e-16 in the quotient.
    if (std::abs(intervals - std::round(intervals)) <= 1e-6 && std::round(intervals) >= 1.0 &&
        intervals <= most_intervals)
        return std::llround(intervals) + 1;
    factor.table.refuse("step",
                        fmt::format("must divide the range from {} to {} into 1 to {} parts", from,
                                    to, most_intervals));
    return std::nullopt;
}

/// A range without levels, over which Latin hypercubes and Sobol sequences spread.
std::optional<Factor> continuous_range(const FactorReader& factor, const core::TomlEntry& entry,
                                       double from, double to) {
    // A factorial design combines levels; a range without levels has none to combine.
    if (factor.context.config.design.type == DesignType::Factorial ||
        factor.parameter.is_whole_number) {
        factor.context.fault("factors", entry,
                             factor.parameter.is_whole_number
                                 ? "a range of whole numbers needs step or count"
                                 : "a range in a factorial design needs step or count");
        return std::nullopt;
    }
    const Unit& unit = factor.parameter.unit;
    return Factor{&factor.parameter,
                  factor.entry.spacing == Spacing::Log
                      ? Distribution::log_uniform(unit.to_si(from), unit.to_si(to))
                      : Distribution::uniform(unit.to_si(from), unit.to_si(to))};
}

std::optional<Factor> read_range(const FactorReader& factor, const core::TomlEntry& entry) {
    const std::size_t errors_before = factor.context.errors.count();
    const core::TomlTable& table = factor.table;
    factor.refuse(distribution_keys, "only with distribution");
    factor.need("from", "a range");
    factor.need("to", "a range");
    const auto from = factor.value("from", factor.entry.from);
    const auto to = factor.value("to", factor.entry.to);
    const bool is_log = factor.entry.spacing == Spacing::Log;
    if (from && to && *from >= *to)
        table.refuse("to", fmt::format("must be greater than from = {}", *from));
    if (is_log && from && *from <= 0.0)
        table.refuse("from", "must be positive for spacing = \"log\"");
    if (table.has("step") && (is_log || table.has("count")))
        table.refuse("step",
                     is_log ? "spacing = \"log\" takes count instead" : "not together with count");
    if (factor.context.errors.count() != errors_before || !from || !to)
        return std::nullopt;
    if (!table.has("step") && !table.has("count"))
        return continuous_range(factor, entry, *from, *to);
    const auto count = level_count(factor, *from, *to);
    if (!count)
        return std::nullopt;
    Levels levels = spaced(*from, *to, *count, is_log);
    for (double& level : levels)
        level = factor.parameter.unit.to_si(level);
    return factor_of(std::move(levels), entry, factor.parameter, factor.context);
}

/// The factor of one entry of [factors], or nothing with the errors recorded.
std::optional<Factor> read_factor(const core::TomlEntry& entry, const Parameter& parameter,
                                  ConfigContext& context) {
    const toml::table* table = entry.node->as_table();
    const bool is_distribution = table != nullptr && table->contains("distribution");
    if (context.config.design.type == DesignType::List && !is_distribution) {
        context.fault("factors", entry,
                      "must be a distribution; a list design takes other values from "
                      "[[design.point]]");
        return std::nullopt;
    }
    if (const toml::array* array = entry.node->as_array())
        return read_levels(*array, entry, parameter, context);
    if (table == nullptr) {
        context.fault("factors", entry,
                      fmt::format("must be a list, a range or a distribution; a single value "
                                  "belongs into [{}]",
                                  parameter.section));
        return std::nullopt;
    }
    FactorReader factor{context.table("factors").table(entry.key), {}, parameter, context};
    std::vector<std::string> names;
    for (const KeyDescription& key : factor_table().keys())
        names.push_back(key.name);
    factor.table.declare("", names);
    const std::size_t errors_before = context.errors.count();
    std::set<std::string> wrong;
    factor_table().read(factor.table, factor.entry, wrong);
    if (context.errors.count() != errors_before)
        return std::nullopt;
    return is_distribution ? read_distribution(factor) : read_range(factor, entry);
}

std::vector<std::string> parameter_keys(const StudyEffects& effects) {
    std::vector<std::string> keys;
    for (const auto& row : effects.rows())
        keys.push_back(row->key);
    for (const Parameter& parameter : parameters())
        keys.emplace_back(parameter.key);
    return keys;
}

/// The parameter of an entry, or nullptr with the error recorded.
const Parameter* parameter_of(const core::TomlEntry& entry, const std::string& section,
                              const ConfigContext& context) {
    const Parameter* parameter = find_parameter(entry.key);
    if (parameter == nullptr)
        parameter = context.config.effects.find(entry.key);
    if (parameter == nullptr)
        context.fault(section, entry,
                      context.root.unknown_key_hint(entry, parameter_keys(context.config.effects)));
    return parameter;
}

/// Reads one [[design.point]] table into the columns, which the first table defines.
void read_point(const toml::table& point, bool is_first, std::vector<Factor>& columns,
                ConfigContext& context) {
    for (const core::TomlEntry& entry : core::entries_in_order(point)) {
        const Parameter* parameter = parameter_of(entry, "design.point", context);
        if (parameter == nullptr)
            continue;
        auto column = std::ranges::find(columns, parameter, &Factor::parameter);
        if (column == columns.end() && !is_first) {
            context.fault("design.point", entry, "the first [[design.point]] does not give it");
            continue;
        }
        if (column == columns.end()) {
            context.note_given(entry.key, {"design.point", entry.line});
            column = columns.insert(columns.end(), Factor{parameter, Levels{}});
        }
        const auto value = parameter_value(*entry.node, *parameter);
        if (!value)
            context.fault("design.point", entry, parameter_allowed(*parameter));
        // A wrong value is replaced by a number, so that the rows below are not shifted while
        // errors are collected.
        std::get<Levels>(column->values).push_back(value.value_or(0.0));
    }
    for (const Factor& column : columns)
        if (!point.contains(column.parameter->key))
            context.errors.add(core::line_of(point),
                               fmt::format("design.point.{} is missing: every [[design.point]] "
                                           "must give what the first gives",
                                           column.parameter->key));
}

void read_points(ConfigContext& context) {
    const toml::node* node = context.table("design").node("point");
    if (node == nullptr || context.config.design.type != DesignType::List)
        return;
    const toml::array* points = node->as_array();
    if (points == nullptr || points->empty() || !points->is_homogeneous<toml::table>()) {
        context.errors.add(core::line_of(*node), "design.point", core::value_text(*node),
                           "must be tables [[design.point]]");
        return;
    }
    std::vector<Factor> columns;
    for (std::size_t i = 0; i < points->size(); ++i)
        read_point(*(*points)[i].as_table(), i == 0, columns, context);
    if (columns.empty())
        context.errors.add(core::line_of(*node), "design.point: must give at least one parameter");
    context.config.design.points = static_cast<std::int64_t>(points->size());
    context.config.factors = std::move(columns);
}

/// Checks that columns from the same rows have the same level, stem or test.
void check_shared_rows(ConfigContext& context) {
    const auto& factors = context.config.factors;
    for (const Factor& factor : factors) {
        const auto first = std::ranges::find_if(factors, [&](const Factor& other) {
            return other.coordinate() == factor.coordinate();
        });
        if (first->is_per_test != factor.is_per_test)
            context.errors.add(context.places.find(factor.parameter->key)->second.line,
                               fmt::format("factors.{}: {} uses the same rows of the file but has "
                                           "another level",
                                           factor.parameter->key, first->parameter->key));
    }
}

/// Records an error if the design would be empty, pointless or too large.
void check_design(ConfigContext& context) {
    const StudyConfig& config = context.config;
    const core::TomlTable table = context.table("design");
    if (config.design.is_sampled() && config.factors.empty())
        table.refuse("type", "needs at least one factor in [factors]");
    const core::TomlTable replicates =
        context.table(context.table("replicates").exists() ? "replicates" : "design");
    const bool draws = std::ranges::any_of(config.factors, &Factor::is_redrawn);
    if (config.design.replicates > 1 && !draws)
        replicates.refuse(
            replicates.has("stems") ? "stems" : "replicates",
            "must be 1, for no factor is a distribution: every replicate would repeat "
            "the same computation");
    // Without drawn values every repetition would be the same computation, although the user
    // expects scatter.
    const bool tests_differ = std::ranges::any_of(config.factors, [](const Factor& factor) {
        return factor.is_per_test || factor.within_stem.has_value();
    });
    if (config.design.tests > 1 && !tests_differ)
        replicates.refuse("within", "must be 1, for no factor has level = \"test\" or within_sd: "
                                    "every test would repeat the same computation");
    check_shared_rows(context);
    // In floating point, because the product of many levels may overflow an integer.
    double points = config.design.type == DesignType::Factorial
                        ? 1.0
                        : static_cast<double>(config.design.points);
    if (config.design.type == DesignType::Factorial)
        for (const Factor& factor : config.factors)
            if (const auto* levels = std::get_if<Levels>(&factor.values))
                points *= static_cast<double>(levels->size());
    points *=
        static_cast<double>(config.design.replicates) * static_cast<double>(config.design.tests);
    if (points > static_cast<double>(most_points))
        context.errors.add(std::max<std::size_t>(table.line("type"), 1),
                           fmt::format("design: {:.6g} points, replicates included; at most {} are "
                                       "possible",
                                       points, most_points));
}

} // namespace

void read_factors(ConfigContext& context) {
    const std::size_t errors_before = context.errors.count();
    read_points(context);
    const core::TomlTable table = context.table("factors");
    for (const core::TomlEntry& entry : table.entries()) {
        const Parameter* parameter = parameter_of(entry, "factors", context);
        table.leave(entry.key);
        if (parameter == nullptr)
            continue;
        context.note_given(entry.key, {"factors", entry.line});
        if (auto factor = read_factor(entry, *parameter, context))
            context.config.factors.push_back(std::move(*factor));
    }
    // Factors that could not be read are missing here and would cause misleading errors.
    if (context.errors.count() == errors_before)
        check_design(context);
}

} // namespace culm::study
