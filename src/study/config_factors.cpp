// SPDX-License-Identifier: BSD-3-Clause
// The factors of a study file: the entries of [factors] and the tables of [[design.point]].
#include "study/config_context.hpp"
#include "study/config_factor_values.hpp"
#include "study/config_hints.hpp"
#include "study/config_reader.hpp"
#include "study/design.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace culm::study {

namespace {

std::vector<std::string> parameter_keys(const StudyEffects& effects) {
    std::vector<std::string> keys = effects.keys();
    for (const Parameter& parameter : parameters())
        keys.emplace_back(parameter.key);
    return keys;
}

/// The parameter of an entry, or nullptr with the error recorded.
const Parameter* parameter_of(const TableEntry& entry, const std::string& section,
                              const ConfigContext& context) {
    const Parameter* parameter = find_parameter(entry.key);
    if (parameter == nullptr)
        parameter = context.config.effects.find(entry.key);
    if (parameter == nullptr)
        context.errors.add(entry.line, section + "." + entry.key, value_text(*entry.node),
                           unknown_key_hint({section, entry.key, entry.node->value<double>()},
                                            parameter_keys(context.config.effects)));
    return parameter;
}

/// Reads one [[design.point]] table into the columns, which the first table defines.
void read_point(const toml::table& point, bool is_first, std::vector<Factor>& columns,
                ConfigContext& context) {
    for (const TableEntry& entry : entries_in_order(point)) {
        const Parameter* parameter = parameter_of(entry, "design.point", context);
        if (parameter == nullptr)
            continue;
        auto column = std::ranges::find(columns, parameter, &Factor::parameter);
        if (column == columns.end() && !is_first) {
            context.errors.add(entry.line, "design.point." + entry.key, value_text(*entry.node),
                               "the first [[design.point]] does not give it");
            continue;
        }
        if (column == columns.end()) {
            context.note_given(entry.key, {"design.point", entry.line});
            column = columns.insert(columns.end(), Factor{parameter, Levels{}});
        }
        const auto value = parameter_value(*entry.node, *parameter);
        if (!value)
            context.errors.add(entry.line, "design.point." + entry.key, value_text(*entry.node),
                               parameter_allowed(*parameter));
        std::get<Levels>(column->values).push_back(value.value_or(0.0));
    }
    for (const Factor& column : columns)
        if (!point.contains(column.parameter->key))
            context.errors.add(line_of(point),
                               fmt::format("design.point.{} is missing: every [[design.point]] "
                                           "must give what the first gives",
                                           column.parameter->key));
}

void read_points(ConfigContext& context) {
    const toml::table* design = context.section("design");
    const toml::node* node = design != nullptr ? design->get("point") : nullptr;
    if (node == nullptr || context.config.design.type != DesignType::List)
        return;
    const toml::array* points = node->as_array();
    if (points == nullptr || points->empty() || !points->is_homogeneous<toml::table>()) {
        context.errors.add(line_of(*node), "design.point", value_text(*node),
                           "must be tables [[design.point]]");
        return;
    }
    std::vector<Factor> columns;
    for (std::size_t i = 0; i < points->size(); ++i)
        read_point(*(*points)[i].as_table(), i == 0, columns, context);
    if (columns.empty())
        context.errors.add(line_of(*node), "design.point: must give at least one parameter");
    context.config.design.points = static_cast<std::int64_t>(points->size());
    context.config.factors = std::move(columns);
}

/// Columns that are taken from the same row are of one stem, or of one test, and of one length.
void check_shared_rows(ConfigContext& context) {
    const auto& factors = context.config.factors;
    for (const Factor& factor : factors) {
        const auto first = std::ranges::find_if(factors, [&](const Factor& other) {
            return other.coordinate() == factor.coordinate();
        });
        if (first->is_per_test != factor.is_per_test)
            context.errors.add(context.places.find(factor.parameter->key)->second.line,
                               fmt::format("factors.{}: {} has rows of the same file together, but "
                                           "another level",
                                           factor.parameter->key, first->parameter->key));
    }
}

/// Records an error if the design would be empty, pointless or too large.
void check_design(ConfigContext& context) {
    const StudyConfig& config = context.config;
    const TableReader reader(context.section("design"), "design", "design", context.errors);
    const bool is_sampled =
        config.design.type == DesignType::LatinHypercube || config.design.type == DesignType::Sobol;
    if (is_sampled && config.factors.empty())
        reader.error("type", "needs at least one factor in [factors]");
    const char* section = context.section("replicates") != nullptr ? "replicates" : "design";
    const TableReader replicates(context.section(section), section, section, context.errors);
    const bool draws = std::ranges::any_of(config.factors, &Factor::is_redrawn);
    if (config.design.replicates > 1 && !draws)
        replicates.error(replicates.has("stems") ? "stems" : "replicates",
                         "must be 1, for no factor is a distribution: every replicate would repeat "
                         "the same computation");
    const bool tests_differ = std::ranges::any_of(config.factors, [](const Factor& factor) {
        return factor.is_per_test || factor.within_stem.has_value();
    });
    if (config.design.tests > 1 && !tests_differ)
        replicates.error("within", "must be 1, for no factor has level = \"test\" or within_sd: "
                                   "every test would repeat the same computation");
    check_shared_rows(context);
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
        context.errors.add(reader.line("type"),
                           fmt::format("design: {:.6g} points, replicates included; at most {} are "
                                       "possible",
                                       points, most_points));
}

} // namespace

void read_factors(ConfigContext& context) {
    const std::size_t errors_before = context.errors.count();
    read_points(context);
    if (const toml::table* table = context.section("factors"))
        for (const TableEntry& entry : entries_in_order(*table)) {
            const Parameter* parameter = parameter_of(entry, "factors", context);
            if (parameter == nullptr)
                continue;
            context.note_given(entry.key, {"factors", entry.line});
            if (auto factor = read_factor(entry, *parameter, context))
                context.config.factors.push_back(std::move(*factor));
        }
    // Factors that could not be read are missing here, and would only cause errors that mislead.
    if (context.errors.count() == errors_before)
        check_design(context);
}

} // namespace culm::study
