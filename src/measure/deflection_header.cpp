// SPDX-License-Identifier: BSD-3-Clause
#include "measure/deflection_header.hpp"

#include "core/decimal_text.hpp"

#include <algorithm>
#include <cctype>
#include <optional>
#include <string_view>

#include <fmt/format.h>

namespace culm::measure {

namespace {

std::string without_spaces(std::string_view text) {
    std::string result;
    for (const char c : text)
        if (c != ' ' && c != '\t')
            result += c;
    return result;
}

/// "h=14mm" taken apart.
struct HeightName {
    std::string number;
    std::string unit;
};

std::optional<HeightName> split_height(std::string_view name) {
    const std::string text = without_spaces(name);
    if (!text.starts_with("h="))
        return std::nullopt;
    const std::size_t end = text.find_last_of("0123456789.");
    if (end == std::string::npos || end < 2)
        return std::nullopt;
    return HeightName{text.substr(2, end - 1), text.substr(end + 1)};
}

std::string column_hint(std::string_view name) {
    if (name.find(',') != std::string_view::npos)
        return "has a decimal comma; write a decimal point";
    std::string lower = without_spaces(name);
    std::ranges::transform(lower, lower.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (core::parse_decimal(lower))
        return fmt::format("must be a height with its unit: write \"h={}mm\"", lower);
    if (lower.starts_with("h="))
        return fmt::format("must be a height with its unit, mm or m: write \"{}\"",
                           lower.find("mm") == std::string::npos ? "h=14mm" : lower);
    return "must be \"h=<height>mm\" (or m), for example \"h=14mm\"; other columns must go "
           "(`culm import` picks columns from any table)";
}

void check_time_name(const DelimitedLine& line, core::FileFaults& faults) {
    const std::string& name = line.cells.front();
    if (name == "time_s")
        return;
    const std::string text = without_spaces(name);
    std::string hint = "the first column must be \"time_s\", the time in s from the release";
    if (text == "time_ms" || text == "time[ms]" || text == "t_ms")
        hint = "time must be in s: divide by 1000 and name the column \"time_s\"";
    else if (core::parse_decimal(text))
        hint = "the file has no header: the first line must be \"time_s,h=<height>mm,...\"";
    else if (text.starts_with("h="))
        hint = "the column \"time_s\" must be the first";
    faults.add(line.number, fmt::format("\"{}\": {}", name, hint));
}

struct Column {
    double height = 0.0; // m
    int power = -3;
};

/// One height column; empty after a fault has been recorded.
std::optional<Column> read_column(const std::string& name, std::size_t line,
                                  core::FileFaults& faults) {
    const std::optional<HeightName> parts = split_height(name);
    const bool known_unit = parts && (parts->unit == "mm" || parts->unit == "m");
    if (parts && !known_unit) {
        faults.add(line,
                   fmt::format(
                       "column \"{}\": {}", name,
                       parts->unit.empty()
                           ? fmt::format("the unit is missing: write \"h={}mm\"", parts->number)
                           : fmt::format("\"{}\" is not a unit known here; mm or m", parts->unit)));
        return std::nullopt;
    }
    const int power = parts && parts->unit == "m" ? 0 : -3;
    const std::optional<double> height =
        parts ? core::parse_decimal(parts->number, power) : std::nullopt;
    if (!height) {
        faults.add(line, fmt::format("column \"{}\" {}", name, column_hint(name)));
        return std::nullopt;
    }
    return Column{*height, power};
}

void check_height(const std::string& name, const DeflectionHeader& header, std::size_t line,
                  const MeasuredStem& stem, core::FileFaults& faults) {
    const double height = header.heights.back();
    if (height < 0.0)
        faults.add(line, fmt::format("column \"{}\" lies below the clamp", name));
    // A mark at the very tip may differ from the length by a rounding of the print.
    if (height > stem.length * (1.0 + 1e-9))
        faults.add(line, fmt::format("column \"{}\" lies above the stem, which is {} mm long", name,
                                     core::decimal_text(stem.length, 3)));
    const auto first = std::ranges::find(header.heights, height);
    if (first + 1 != header.heights.end())
        faults.add(line, fmt::format("column \"{}\": column {} has the same height", name,
                                     first - header.heights.begin() + 2));
}

/// The whole line in one cell, or another separator in the first one.
bool has_other_delimiter(const DelimitedLine& line, core::FileFaults& faults) {
    const std::string& first = line.cells.front();
    if (first.starts_with("sep=")) {
        faults.add(
            line.number,
            "\"sep=\" is a note for a spreadsheet: delete the line, separate cells by commas");
        return true;
    }
    for (const auto& [delimiter, word] :
         {std::pair{';', "semicolons"}, std::pair{'\t', "tabulators"}, std::pair{'|', "bars"}})
        if (first.find(delimiter) != std::string::npos) {
            faults.add(line.number, fmt::format("cells are separated by {}; write commas, and "
                                                "decimal points in the numbers",
                                                word));
            return true;
        }
    if (line.cells.size() == 1 && first.find(' ') != std::string::npos) {
        faults.add(line.number, "cells are separated by spaces; write commas");
        return true;
    }
    return false;
}

} // namespace

DeflectionHeader read_deflection_header(const DelimitedLine& line, const MeasuredStem& stem,
                                        core::FileFaults& faults) {
    DeflectionHeader header;
    if (has_other_delimiter(line, faults))
        return header;
    check_time_name(line, faults);
    std::size_t named = line.cells.size();
    while (named > 1 && line.cells[named - 1].empty())
        --named;
    header.unnamed = line.cells.size() - named;
    if (named == 1)
        faults.add(line.number, "there is no height: the columns after time_s must be "
                                "\"h=<height>mm\"");
    if (named > most_heights + 1) {
        faults.add(line.number,
                   fmt::format("{} heights; at most {} are allowed", named - 1, most_heights));
        return header;
    }
    std::optional<int> power;
    for (std::size_t i = 1; i < named; ++i) {
        const std::optional<Column> column = read_column(line.cells[i], line.number, faults);
        if (!column)
            continue;
        if (power && column->power != *power)
            faults.add(line.number, fmt::format("column \"{}\": all heights must have one unit, "
                                                "which is that of the deflections as well",
                                                line.cells[i]));
        power = column->power;
        header.heights.push_back(column->height);
        check_height(line.cells[i], header, line.number, stem, faults);
    }
    header.power_of_ten = power.value_or(-3);
    return header;
}

} // namespace culm::measure
