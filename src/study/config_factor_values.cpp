// SPDX-License-Identifier: BSD-3-Clause
#include "study/config_factor_table.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace culm::study {

namespace {

/// Levels must be whole for whole-number parameters, and each must occur once.
bool check_levels(const Levels& levels, const TableEntry& entry, const Parameter& parameter,
                  ConfigErrors& errors) {
    const std::string key = "factors." + entry.key;
    if (parameter.is_whole_number &&
        std::ranges::any_of(levels, [](double v) { return v != std::round(v); })) {
        errors.add(entry.line, key, value_text(*entry.node), "levels must be whole numbers");
        return false;
    }
    Levels sorted = levels;
    std::ranges::sort(sorted);
    if (const auto twice = std::ranges::adjacent_find(sorted); twice != sorted.end()) {
        errors.add(entry.line, key, value_text(*entry.node),
                   fmt::format("must name {} once only", config_text(parameter, *twice)));
        return false;
    }
    return true;
}

std::optional<Factor> read_levels(const toml::array& array, const TableEntry& entry,
                                  const Parameter& parameter, ConfigErrors& errors) {
    Levels levels;
    for (const toml::node& node : array) {
        const auto value = parameter_value(node, parameter);
        if (!value) {
            errors.add(line_of(node), "factors." + entry.key, value_text(node),
                       parameter_allowed(parameter));
            return std::nullopt;
        }
        levels.push_back(*value);
    }
    if (levels.empty()) {
        errors.add(entry.line, "factors." + entry.key, "[]", "must name at least one value");
        return std::nullopt;
    }
    if (!check_levels(levels, entry, parameter, errors))
        return std::nullopt;
    return Factor{&parameter, std::move(levels)};
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

/// How many levels `step` or `count` give; nothing (with the error recorded) if they are wrong.
std::optional<std::int64_t> level_count(const FactorTable& table, double from, double to) {
    if (table.reader.has("count"))
        return table.reader.whole_number("count");
    const auto step = table.reader.number("step");
    if (!step)
        return std::nullopt;
    const double intervals = (to - from) / *step;
    constexpr double most_intervals = 1e6;
    // Decimal inputs leave some 1e-16 of the quotient.
    if (std::abs(intervals - std::round(intervals)) <= 1e-6 && std::round(intervals) >= 1.0 &&
        intervals <= most_intervals)
        return std::llround(intervals) + 1;
    table.reader.error("step", fmt::format("must divide the range from {} to {} into 1 to {} parts",
                                           from, to, most_intervals));
    return std::nullopt;
}

/// A range without levels, over which Latin hypercubes and Sobol sequences spread.
std::optional<Factor> continuous_range(const FactorTable& table, const TableEntry& entry,
                                       double from, double to, bool is_log) {
    if (table.context.config.design.type == DesignType::Factorial ||
        table.parameter.is_whole_number) {
        table.context.errors.add(entry.line, "factors." + entry.key, value_text(*entry.node),
                                 table.parameter.is_whole_number
                                     ? "a range of whole numbers needs step or count"
                                     : "a range in a factorial design needs step or count");
        return std::nullopt;
    }
    const Unit& unit = table.parameter.unit;
    return Factor{&table.parameter,
                  is_log ? Distribution::log_uniform(unit.to_si(from), unit.to_si(to))
                         : Distribution::uniform(unit.to_si(from), unit.to_si(to))};
}

std::optional<Factor> read_range(const FactorTable& table, const TableEntry& entry) {
    const std::size_t errors_before = table.context.errors.count();
    table.refuse(distribution_keys, "only with distribution");
    table.need("from", "a range");
    table.need("to", "a range");
    const auto from = table.value("from");
    const auto to = table.value("to");
    const bool is_log = table.reader.word("spacing").value_or("linear") == "log";
    if (from && to && *from >= *to)
        table.reader.error("to", fmt::format("must be greater than from = {}", *from));
    if (is_log && from && *from <= 0.0)
        table.reader.error("from", "must be positive for spacing = \"log\"");
    if (table.reader.has("step") && (is_log || table.reader.has("count")))
        table.reader.error("step", is_log ? "spacing = \"log\" takes count instead"
                                          : "not together with count");
    if (table.context.errors.count() != errors_before || !from || !to)
        return std::nullopt;
    if (!table.reader.has("step") && !table.reader.has("count"))
        return continuous_range(table, entry, *from, *to, is_log);
    const auto count = level_count(table, *from, *to);
    if (!count)
        return std::nullopt;
    Levels levels = spaced(*from, *to, *count, is_log);
    for (double& level : levels)
        level = table.parameter.unit.to_si(level);
    if (!check_levels(levels, entry, table.parameter, table.context.errors))
        return std::nullopt;
    return Factor{&table.parameter, std::move(levels)};
}

} // namespace

std::optional<double> parameter_value(const toml::node& node, const Parameter& parameter) {
    const bool right_type = parameter.is_whole_number ? node.is_integer() : node.is_number();
    const auto value = node.value<double>();
    if (right_type && value && parameter.range.contains(*value))
        return parameter.unit.to_si(*value);
    return std::nullopt;
}

std::string parameter_allowed(const Parameter& parameter) {
    for (const ConfigKey& key : config_keys_of(parameter.section))
        if (key.key == parameter.key)
            return "must be " + key.allowed();
    return {};
}

std::optional<Factor> read_factor(const TableEntry& entry, const Parameter& parameter,
                                  ConfigContext& context) {
    const toml::table* table = entry.node->as_table();
    const bool is_distribution = table != nullptr && table->contains("distribution");
    if (context.config.design.type == DesignType::List && !is_distribution) {
        context.errors.add(entry.line, "factors." + entry.key, value_text(*entry.node),
                           "must be a distribution; a list design takes other values from "
                           "[[design.point]]");
        return std::nullopt;
    }
    if (const toml::array* array = entry.node->as_array())
        return read_levels(*array, entry, parameter, context.errors);
    if (table == nullptr) {
        context.errors.add(entry.line, "factors." + entry.key, value_text(*entry.node),
                           fmt::format("must be a list, a range or a distribution; a single value "
                                       "belongs into [{}]",
                                       parameter.section));
        return std::nullopt;
    }
    const FactorTable factor{
        TableReader(table, "factors." + entry.key, "factors.<parameter>", context.errors),
        parameter, context};
    factor.reader.refuse_unknown_keys();
    return is_distribution ? read_distribution(factor) : read_range(factor, entry);
}

} // namespace culm::study
