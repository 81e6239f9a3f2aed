// SPDX-License-Identifier: BSD-3-Clause
#include "study/measured_column.hpp"

#include "core/decimal_text.hpp"
#include "core/error.hpp"
#include "core/nearest_name.hpp"
#include "measure/folder/delimited_text.hpp"

#include <algorithm>
#include <cctype>

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
    for (const char candidate : {',', ';', '\t'})
        if (std::ranges::count(header, candidate) > std::ranges::count(header, best))
            best = candidate;
    return best;
}

/// The unit of that name, as keys end with it or as it is printed ("GPa", "kg/m3").
std::optional<Unit> unit_named(std::string_view name) {
    std::string suffix;
    for (const char c : name)
        suffix += c == '/' ? '_' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    const std::string key = "x_" + suffix;
    const KeyParts parts = split_key(key);
    return parts.quantity == "x" ? parts.unit : std::nullopt;
}

Unit unit_of(const ColumnRequest& request, const Parameter& parameter) {
    const bool is_given = !request.unit.empty();
    const std::optional<Unit> unit =
        is_given ? unit_named(request.unit) : split_key(request.column).unit;
    if (is_given && !unit)
        throw core::InputError(fmt::format("{}: unknown unit {}", request.file, request.unit));
    if (!unit)
        return parameter.unit;
    if (unit->dimension != parameter.unit.dimension)
        throw core::InputError(
            fmt::format("{}: column {} is in {}, but {} is in {}; `unit` tells another unit",
                        request.file, request.column, unit->name, parameter.key,
                        parameter.unit.name.empty() ? "no unit" : parameter.unit.name));
    return *unit;
}

std::size_t place_of(const measure::DelimitedLine& header, const ColumnRequest& request) {
    const auto found = std::ranges::find(header.cells, request.column);
    if (found != header.cells.end())
        return static_cast<std::size_t>(found - header.cells.begin());
    const std::string nearest = core::nearest_name(request.column, header.cells);
    throw core::InputError(fmt::format(
        "{}:{}: no column {}{}; there are {}", request.file, header.number, request.column,
        nearest.empty() ? "" : fmt::format(" (did you mean {}?)", nearest),
        fmt::join(header.cells, ", ")));
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

} // namespace culm::study
