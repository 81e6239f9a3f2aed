// SPDX-License-Identifier: BSD-3-Clause
// Factors that are drawn: distributions, columns of measured stems.
#include "core/decimal_text.hpp"
#include "core/error.hpp"
#include "core/nearest_name.hpp"
#include "measure/folder/delimited_text.hpp"
#include "study/config/keys.hpp"
#include "study/config/sections.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::study {

namespace {

/// The delimiter that the header holds most often.
char delimiter_of(std::string_view text) {
    const auto lines = measure::split_table(text, '\0');
    if (lines.empty())
        return ',';
    const std::string& header = lines.front().cells.front();
    char best = ',';
    // Spreadsheets write semicolons in countries with a decimal comma.
    for (const char candidate : {',', ';', '\t'})
        if (std::ranges::count(header, candidate) > std::ranges::count(header, best))
            best = candidate;
    return best;
}

/// The unit with that name, as a suffix of keys or as it is printed ("GPa", "kg/m3").
std::optional<Unit> unit_named(std::string_view name) {
    std::string suffix;
    for (const char c : name)
        suffix += c == '/' ? '_' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    // Units are defined as suffixes of keys: any key with this suffix shows whether there is such
    // a unit.
    const std::string key = "x_" + suffix;
    const core::KeyParts parts = core::split_key(key);
    return parts.quantity == "x" ? parts.unit : std::nullopt;
}

Unit unit_of(const ColumnRequest& request, const Parameter& parameter) {
    const bool is_given = !request.unit.empty();
    const std::optional<Unit> unit =
        is_given ? unit_named(request.unit) : core::split_key(request.column).unit;
    if (is_given && !unit)
        throw core::InputError(fmt::format("{}: unknown unit {}", request.file, request.unit));
    if (!unit)
        return parameter.unit;
    // Otherwise a density that is read as a length would not be noticed.
    if (unit->dimension != parameter.unit.dimension)
        throw core::InputError(
            fmt::format("{}: column {} is in {}, but {} is in {}; `unit` sets another unit",
                        request.file, request.column, unit->name, parameter.key,
                        parameter.unit.name.empty() ? "no unit" : parameter.unit.name));
    return *unit;
}

std::size_t place_of(const measure::DelimitedLine& header, const ColumnRequest& request) {
    const auto found = std::ranges::find(header.cells, request.column);
    if (found != header.cells.end())
        return static_cast<std::size_t>(found - header.cells.begin());
    throw core::InputError(fmt::format(
        "{}:{}: no column {}{}; there are {}", request.file, header.number, request.column,
        core::did_you_mean(request.column, header.cells, ""), fmt::join(header.cells, ", ")));
}

// A smaller share of the unconfined distribution within [min, max] indicates a wrong limit.
constexpr double smallest_kept_probability = 1e-3;

constexpr std::array<std::string_view, 4> column_keys{"file", "column", "unit", "rows"};

/// The ends of the parameter's allowed range that belong to it, in its unit.
std::pair<double, double> allowed_ends(const Interval& range) {
    return {range.low_open ? std::nextafter(range.low, range.high) : range.low,
            range.high_open ? std::nextafter(range.high, range.low) : range.high};
}

/// [min, max] in the parameter's unit: as given, or the allowed ends.
std::pair<double, double> truncation(const FactorReader& factor) {
    const auto [lowest, highest] = allowed_ends(factor.parameter.range);
    const bool is_lognormal = factor.entry.distribution == DrawnFrom::Lognormal;
    return {factor.value("min", factor.entry.min)
                .value_or(is_lognormal ? std::max(lowest, 0.0) : lowest),
            factor.value("max", factor.entry.max).value_or(highest)};
}

/// A distribution that is defined by a formula, called `name`.
std::optional<Distribution> read_formula(const FactorReader& factor, const std::string& name) {
    const std::size_t errors_before = factor.context.errors.count();
    const core::TomlTable& table = factor.table;
    const bool is_uniform = factor.entry.distribution == DrawnFrom::Uniform;
    const bool is_lognormal = factor.entry.distribution == DrawnFrom::Lognormal;
    factor.refuse(column_keys, "only with distribution = \"empirical\"");
    if (is_uniform)
        factor.refuse(std::array{"mean", "sd"}, "a uniform distribution takes min and max");
    for (const char* key : is_uniform ? std::array{"min", "max"} : std::array{"mean", "sd"})
        factor.need(key, fmt::format("distribution = \"{}\"", name));
    const auto mean = factor.value("mean", factor.entry.mean);
    const auto [min, max] = truncation(factor);
    if (is_lognormal && mean && *mean <= 0.0)
        table.refuse("mean", "must be positive for a lognormal distribution");
    if (is_lognormal && min < 0.0)
        table.refuse("min", "must not be negative for a lognormal distribution");
    if (factor.context.errors.count() == errors_before && min >= max)
        table.refuse(table.has("max") ? "max" : "min",
                     fmt::format("max = {} must be greater than min = {}", max, min));
    if (factor.context.errors.count() != errors_before)
        return std::nullopt;
    const Unit& unit = factor.parameter.unit;
    const double low = unit.to_si(min);
    const double high = unit.to_si(max);
    const double center = unit.to_si(mean.value_or(0.0));
    const double sd = unit.to_si(factor.entry.sd.value_or(0.0));
    const Distribution distribution = is_uniform ? Distribution::uniform(low, high)
                                      : is_lognormal
                                          ? Distribution::lognormal(center, sd, low, high)
                                          : Distribution::normal(center, sd, low, high);
    // Draws are made by the quantile of the truncated distribution. In the far tail it depends on
    // the assumed shape alone, which no measurement supports there.
    if (distribution.kept_probability() < smallest_kept_probability) {
        table.refuse("mean", fmt::format("only {:.2g} of the distribution lies between min = {} "
                                         "and max = {}; at least {} must",
                                         distribution.kept_probability(), min, max,
                                         smallest_kept_probability));
        return std::nullopt;
    }
    return distribution;
}

std::optional<Factor> read_empirical(const FactorReader& factor) {
    factor.refuse(std::array{"mean", "sd", "min", "max"},
                  "an empirical distribution takes the values of its file as they are");
    for (const char* key : {"file", "column"})
        factor.need(key, "distribution = \"empirical\"");
    const FactorEntry& entry = factor.entry;
    if (entry.file.empty() || entry.column.empty())
        return std::nullopt;
    const bool keeps_rows = entry.rows == Rows::Together;
    try {
        std::vector<double> values =
            measured_values(text_of_named_file(factor.context, entry.file),
                            {entry.file, entry.column, entry.unit, keeps_rows}, factor.parameter);
        // Sorted, so that strata of the unit interval are strata of the values; rows that stay
        // together keep the order of the file, which the columns share.
        if (!keeps_rows)
            std::ranges::sort(values);
        Factor drawn{&factor.parameter, Distribution::empirical(std::move(values)), true};
        drawn.measured = MeasuredColumn{entry.file, entry.column, keeps_rows};
        return drawn;
    } catch (const core::InputError& error) {
        factor.table.refuse("file", error.what());
        return std::nullopt;
    }
}

std::optional<WithinStemScatter> scatter_of(const FactorReader& factor) {
    if (!factor.entry.within_sd)
        return std::nullopt;
    const Unit& unit = factor.parameter.unit;
    const auto [lowest, highest] = allowed_ends(factor.parameter.range);
    return WithinStemScatter{unit.to_si(*factor.entry.within_sd), unit.to_si(lowest),
                             unit.to_si(highest)};
}

} // namespace

std::vector<double> measured_values(std::string_view text, const ColumnRequest& request,
                                    const Parameter& parameter) {
    if (constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
        text.starts_with(byte_order_mark))
        text.remove_prefix(byte_order_mark.size());
    const auto lines = measure::split_table(text, delimiter_of(text));
    if (lines.empty())
        throw core::InputError(fmt::format("{}: the table is empty", request.file));
    const std::size_t place = place_of(lines.front(), request);
    const Unit unit = unit_of(request, parameter);
    std::vector<double> values;
    for (std::size_t row = 1; row < lines.size(); ++row) {
        const auto refuse = [&](const std::string& cell, const std::string& reason) {
            throw core::InputError(fmt::format("{}:{}: {} = {}: {}", request.file,
                                               lines[row].number, request.column, cell, reason));
        };
        const auto& cells = lines[row].cells;
        const std::string cell = place < cells.size() ? cells[place] : std::string();
        // A stem with a missing value cannot be drawn as a whole.
        if (cell.empty() && request.keeps_rows)
            refuse("(empty)", "rows = \"together\" needs every cell");
        if (cell.empty())
            continue;
        const auto value = core::parse_decimal(cell, unit.power_of_ten);
        if (!value)
            refuse(cell, measure::why_not_a_number(cell));
        if (!parameter.range.contains(parameter.unit.from_si(*value)))
            refuse(cell, fmt::format("{} must be in {}{}{}", parameter.key, parameter.range.text(),
                                     parameter.unit.name.empty() ? "" : " ", parameter.unit.name));
        values.push_back(*value);
    }
    if (values.empty())
        throw core::InputError(
            fmt::format("{}: column {} holds no number", request.file, request.column));
    return values;
}

std::optional<Factor> read_distribution(const FactorReader& factor) {
    const std::size_t errors_before = factor.context.errors.count();
    factor.refuse(range_keys, "only for a range, without distribution");
    if (factor.parameter.is_whole_number)
        factor.table.refuse("distribution", "whole numbers take a list or a range");
    std::optional<Factor> drawn;
    const std::string name = factor.table.node("distribution")->value_or<std::string>("");
    if (factor.entry.distribution == DrawnFrom::Empirical)
        drawn = read_empirical(factor);
    else if (auto distribution = read_formula(factor, name))
        drawn = Factor{&factor.parameter, std::move(*distribution), true};
    const bool is_per_test = factor.entry.level == Level::Test;
    if (is_per_test && factor.entry.within_sd)
        factor.table.refuse("within_sd", "not with level = \"test\": the tests of a stem have no "
                                         "value of the stem to scatter about");
    if (!drawn || factor.context.errors.count() != errors_before)
        return std::nullopt;
    drawn->is_per_test = is_per_test;
    drawn->within_stem = scatter_of(factor);
    return drawn;
}

} // namespace culm::study
