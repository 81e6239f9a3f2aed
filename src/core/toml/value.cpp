// SPDX-License-Identifier: BSD-3-Clause
#include "core/toml/value.hpp"

#include "core/decimal_text.hpp"
#include "core/error.hpp"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <sstream>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::core {

namespace {

/// "157,0" in a line of TOML, which reads as two values.
bool has_decimal_comma(std::string_view line) {
    const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
    if (line.find_first_of("[{") != std::string::npos)
        return false;
    // In lists and inline tables a comma between digits is right.
    for (std::size_t i = 1; i + 1 < line.size(); ++i)
        if (line[i] == ',' && is_digit(line[i - 1]) && is_digit(line[i + 1]))
            return true;
    return false;
}

std::string_view line_of_text(std::string_view text, std::size_t number) {
    for (std::size_t i = 1; i < number && !text.empty(); ++i)
        text.remove_prefix(std::min(text.size(), text.find('\n') + 1));
    return text.substr(0, text.find('\n'));
}

std::string full_text(const toml::node& node) {
    if (const auto whole = node.value_exact<std::int64_t>())
        return fmt::format("{}", *whole);
    if (const auto real = node.value_exact<double>())
        return fmt::format("{}", *real);
    if (const auto text = node.value_exact<std::string>())
        return fmt::format("\"{}\"", *text);
    std::vector<std::string> parts;
    if (const toml::array* array = node.as_array()) {
        for (const toml::node& element : *array)
            parts.push_back(full_text(element));
        return fmt::format("[{}]", fmt::join(parts, ", "));
    }
    if (const toml::table* table = node.as_table()) {
        for (const TomlEntry& entry : entries_in_order(*table))
            parts.push_back(fmt::format("{} = {}", entry.key, full_text(*entry.node)));
        return fmt::format("{{ {} }}", fmt::join(parts, ", "));
    }
    std::ostringstream stream; // truth values, dates and times
    node.visit([&](const auto& value) { stream << toml::toml_formatter{value}; });
    return stream.str();
}

} // namespace

toml::table parse_toml_text(std::string_view text, const std::string& file) {
    try {
        return toml::parse(text, std::string_view(file));
    } catch (const toml::parse_error& error) {
        const toml::source_position place = error.source().begin;
        const bool comma = has_decimal_comma(line_of_text(text, place.line));
        throw InputError(fmt::format("{}:{}: not valid TOML: {} (column {}){}", file, place.line,
                                     error.description(), place.column,
                                     comma ? " (a decimal comma? write a point)" : ""));
    }
}

std::string one_of(std::span<const std::string> words) {
    std::string text;
    for (std::size_t i = 0; i < words.size(); ++i) {
        const char* separator = i == 0 ? "" : i + 1 == words.size() ? " or " : ", ";
        text += fmt::format("{}\"{}\"", separator, words[i]);
    }
    return text;
}

std::string value_text(const toml::node& node) {
    const std::string text = full_text(node);
    constexpr std::size_t longest = 60;
    return text.size() > longest ? text.substr(0, longest) + " ..." : text;
}

std::vector<TomlEntry> entries_in_order(const toml::table& table) {
    std::vector<std::pair<toml::source_position, TomlEntry>> found;
    for (const auto& [key, node] : table)
        found.emplace_back(key.source().begin,
                           TomlEntry{std::string(key.str()), &node, key.source().begin.line});
    std::ranges::sort(found, [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<TomlEntry> entries;
    entries.reserve(found.size());
    for (auto& [position, entry] : found)
        entries.push_back(std::move(entry));
    return entries;
}

std::string_view written_text(const toml::node& node, std::string_view text) {
    const toml::source_position begin = node.source().begin;
    std::string_view line = line_of_text(text, begin.line);
    // Columns count characters; the text before a number may contain more than ASCII.
    for (std::size_t column = 1; column < begin.column && !line.empty(); ++column) {
        line.remove_prefix(1);
        while (!line.empty() && (static_cast<unsigned char>(line.front()) & 0xC0U) == 0x80U)
            line.remove_prefix(1);
    }
    return line.substr(0, line.find_first_not_of("0123456789_+-.eE"));
}

double last_digit(std::string_view number) {
    const std::string_view digits = number.substr(0, number.find_first_of("eE"));
    std::string_view exponent = number.substr(std::min(number.size(), digits.size() + 1));
    exponent.remove_prefix(exponent.starts_with('+') ? 1 : 0);
    int power = 0;
    std::from_chars(exponent.data(), exponent.data() + exponent.size(), power);
    if (const std::size_t point = digits.find('.'); point != std::string_view::npos)
        power -= static_cast<int>(std::ranges::count_if(
            digits.substr(point), [](char c) { return c >= '0' && c <= '9'; }));
    return with_point_moved(1.0, power);
}

} // namespace culm::core
