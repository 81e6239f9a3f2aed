// SPDX-License-Identifier: BSD-3-Clause
// Factors that are drawn: the keys of `distribution`.
#include "core/error.hpp"
#include "study/config_factor_table.hpp"
#include "study/measured_column.hpp"
#include "study/study_files.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace culm::study {

namespace {

// Less than this share of the unconfined distribution within [min, max] is a mistaken limit.
constexpr double smallest_kept_probability = 1e-3;

constexpr std::array<std::string_view, 4> column_keys{"file", "column", "unit", "rows"};

/// The ends of the parameter's allowed range that belong to it, in its unit.
std::pair<double, double> allowed_ends(const Interval& range) {
    return {range.low_open ? std::nextafter(range.low, range.high) : range.low,
            range.high_open ? std::nextafter(range.high, range.low) : range.high};
}

/// [min, max] in the parameter's unit: as given, or the allowed ends.
std::pair<double, double> truncation(const FactorTable& table, bool is_lognormal) {
    const auto [lowest, highest] = allowed_ends(table.parameter.range);
    return {table.value("min").value_or(is_lognormal ? std::max(lowest, 0.0) : lowest),
            table.value("max").value_or(highest)};
}

/// A distribution that a formula gives.
std::optional<Distribution> read_formula(const FactorTable& table, const std::string& kind) {
    const std::size_t errors_before = table.context.errors.count();
    const bool is_uniform = kind == "uniform";
    const bool is_lognormal = kind == "lognormal";
    table.refuse(column_keys, "only with distribution = \"empirical\"");
    if (is_uniform)
        table.refuse(std::array{"mean", "sd"}, "a uniform distribution takes min and max");
    for (const char* key : is_uniform ? std::array{"min", "max"} : std::array{"mean", "sd"})
        table.need(key, fmt::format("distribution = \"{}\"", kind));
    const auto mean = table.value("mean");
    const auto sd = table.reader.number("sd");
    const std::pair<double, double> limits = truncation(table, is_lognormal);
    const double min = limits.first;
    const double max = limits.second;
    if (is_lognormal && mean && *mean <= 0.0)
        table.reader.error("mean", "must be positive for a lognormal distribution");
    if (is_lognormal && min < 0.0)
        table.reader.error("min", "must not be negative for a lognormal distribution");
    if (table.context.errors.count() == errors_before && min >= max)
        table.reader.error(table.reader.has("max") ? "max" : "min",
                           fmt::format("max = {} must be greater than min = {}", max, min));
    if (table.context.errors.count() != errors_before)
        return std::nullopt;
    const auto si = [&](double v) { return table.parameter.unit.to_si(v); };
    const auto make = [&] {
        if (is_uniform)
            return Distribution::uniform(si(min), si(max));
        return is_lognormal ? Distribution::lognormal(si(*mean), si(*sd), si(min), si(max))
                            : Distribution::normal(si(*mean), si(*sd), si(min), si(max));
    };
    Distribution distribution = make();
    if (distribution.kept_probability() < smallest_kept_probability) {
        table.reader.error("mean", fmt::format("only {:.2g} of the distribution lies between min = "
                                               "{} and max = {}; at least {} must",
                                               distribution.kept_probability(), min, max,
                                               smallest_kept_probability));
        return std::nullopt;
    }
    return distribution;
}

std::optional<Factor> read_empirical(const FactorTable& table) {
    table.refuse(std::array{"mean", "sd", "min", "max"},
                 "an empirical distribution takes the values of its file as they are");
    for (const char* key : {"file", "column"})
        table.need(key, "distribution = \"empirical\"");
    const auto file = table.reader.text("file");
    const auto column = table.reader.text("column");
    const std::string unit = table.reader.text("unit").value_or("");
    const bool keeps_rows = table.reader.word("rows").value_or("independent") == "together";
    if (!file || !column)
        return std::nullopt;
    try {
        std::vector<double> values =
            measured_values(text_of_named_file(table.context, *file),
                            {*file, *column, unit, keeps_rows}, table.parameter);
        if (!keeps_rows)
            std::ranges::sort(values);
        Factor factor{&table.parameter, Distribution::empirical(std::move(values)), true};
        factor.measured = MeasuredColumn{*file, *column, keeps_rows};
        return factor;
    } catch (const core::InputError& error) {
        table.reader.error("file", error.what());
        return std::nullopt;
    }
}

std::optional<WithinStemScatter> read_scatter(const FactorTable& table) {
    const auto sd = table.reader.number("within_sd");
    if (!sd)
        return std::nullopt;
    const Unit& unit = table.parameter.unit;
    const auto [lowest, highest] = allowed_ends(table.parameter.range);
    return WithinStemScatter{unit.to_si(*sd), unit.to_si(lowest), unit.to_si(highest)};
}

} // namespace

std::optional<Factor> read_distribution(const FactorTable& table) {
    const std::size_t errors_before = table.context.errors.count();
    table.refuse(range_keys, "only for a range, without distribution");
    const auto kind = table.reader.word("distribution");
    if (!kind)
        return std::nullopt;
    if (table.parameter.is_whole_number)
        table.reader.error("distribution", "whole numbers take a list or a range");
    std::optional<Factor> factor;
    if (*kind == "empirical")
        factor = read_empirical(table);
    else if (auto distribution = read_formula(table, *kind))
        factor = Factor{&table.parameter, std::move(*distribution), true};
    const bool is_per_test = table.reader.word("level").value_or("stem") == "test";
    const auto within_stem = read_scatter(table);
    if (is_per_test && table.reader.has("within_sd"))
        table.reader.error("within_sd", "not with level = \"test\": the tests of a stem have no "
                                        "value of the stem to scatter about");
    if (!factor || table.context.errors.count() != errors_before)
        return std::nullopt;
    factor->is_per_test = is_per_test;
    factor->within_stem = within_stem;
    return factor;
}

} // namespace culm::study
