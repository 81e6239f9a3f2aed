// SPDX-License-Identifier: BSD-3-Clause
#include "measure/toml_table.hpp"

#include "core/error.hpp"
#include "core/file_text.hpp"
#include "core/nearest_name.hpp"
#include "measure/decimal_text.hpp"

#include <algorithm>
#include <array>
#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::measure {

namespace {

std::string value_text(const toml::node& node) {
    if (const auto real = node.value_exact<double>())
        return fmt::format("{}", *real);
    std::ostringstream stream;
    node.visit([&](const auto& value) { stream << toml::toml_formatter{value}; });
    constexpr std::size_t longest = 60;
    const std::string text = stream.str();
    return text.size() > longest ? text.substr(0, longest) + " ..." : text;
}

/// "157,0" in a line of TOML, which reads as two values.
bool has_decimal_comma(const std::string& line) {
    const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
    if (line.find_first_of("[{") != std::string::npos)
        return false;
    for (std::size_t i = 1; i + 1 < line.size(); ++i)
        if (line[i] == ',' && is_digit(line[i - 1]) && is_digit(line[i + 1]))
            return true;
    return false;
}

std::string line_of_text(const std::string& text, std::size_t number) {
    std::istringstream stream(text);
    std::string line;
    for (std::size_t i = 0; i < number; ++i)
        std::getline(stream, line);
    return line;
}

/// Without its unit: "length_mm" is "length".
std::string_view quantity_of(std::string_view key) {
    constexpr std::array<std::string_view, 13> units{"_mm",    "_m",     "_cm", "_um",  "_g",
                                                     "_kg",    "_mm2",   "_m2", "_mm4", "_m4",
                                                     "_kg_m3", "_g_cm3", "_s"};
    std::size_t longest = 0;
    for (const std::string_view unit : units)
        if (key.ends_with(unit) && key.size() > unit.size())
            longest = std::max(longest, unit.size());
    return key.substr(0, key.size() - longest);
}

std::string allowed_range(const NumberRange& range) {
    return fmt::format("must be a number in {}{}, {}]", range.low_is_open ? '(' : '[', range.low,
                       range.high);
}

} // namespace

toml::table parse_toml_file(const std::filesystem::path& file) {
    return parse_toml_text(core::file_text(file), file.string());
}

toml::table parse_toml_text(const std::string& text, const std::string& file) {
    try {
        return toml::parse(text, std::string_view(file));
    } catch (const toml::parse_error& error) {
        const std::size_t line = error.source().begin.line;
        const bool comma = has_decimal_comma(line_of_text(text, line));
        throw core::InputError(fmt::format("{}:{}: {}{}", file, line, error.description(),
                                           comma ? " (a decimal comma? write a point)" : ""));
    }
}

TomlTable::TomlTable(const toml::table* table, std::string name, FileFaults& faults)
    : table_(table), name_(std::move(name)), faults_(&faults) {}

bool TomlTable::has(std::string_view key) const {
    return table_ != nullptr && table_->contains(key);
}

bool TomlTable::is_text(std::string_view key) const {
    return has(key) && table_->get(key)->is_string();
}

std::size_t TomlTable::line(std::string_view key) const {
    if (table_ == nullptr)
        return 0;
    const toml::node* found = table_->get(key);
    return found != nullptr ? found->source().begin.line : table_->source().begin.line;
}

std::optional<std::string> TomlTable::text(const std::string& key) {
    const toml::node* found = ask(key);
    if (found == nullptr)
        return std::nullopt;
    auto value = found->value_exact<std::string>();
    if (value && !value->empty())
        return value;
    fault(key, "must be a text in quotes");
    return std::nullopt;
}

std::optional<std::size_t> TomlTable::word(const std::string& key,
                                           std::span<const std::string> valid) {
    const toml::node* found = ask(key);
    if (found == nullptr)
        return std::nullopt;
    const std::string value = found->value_exact<std::string>().value_or("");
    if (const auto match = std::ranges::find(valid, value); match != valid.end())
        return static_cast<std::size_t>(match - valid.begin());
    const std::string nearest = core::nearest_name(value, valid);
    fault(key, fmt::format("must be one of \"{}\"{}", fmt::join(valid, "\", \""),
                           nearest.empty() ? "" : fmt::format(" (did you mean \"{}\"?)", nearest)));
    return std::nullopt;
}

std::optional<double> TomlTable::number(const std::string& key, const NumberRange& range) {
    const toml::node* found = ask(key);
    if (found == nullptr)
        return std::nullopt;
    if (found->is_string())
        fault(key, "must be a number without quotes, with a decimal point");
    else if (const auto value = found->value<double>();
             found->is_number() && range.contains(*value))
        return value;
    else
        fault(key, allowed_range(range));
    return std::nullopt;
}

std::optional<std::int64_t> TomlTable::whole_number(const std::string& key,
                                                    const NumberRange& range) {
    const toml::node* found = ask(key);
    if (found == nullptr)
        return std::nullopt;
    if (const auto value = found->value_exact<std::int64_t>();
        value && range.contains(static_cast<double>(*value)))
        return value;
    fault(key, fmt::format("must be a whole number from {} to {}", range.low, range.high));
    return std::nullopt;
}

std::optional<bool> TomlTable::flag(const std::string& key) {
    const toml::node* found = ask(key);
    if (found == nullptr)
        return std::nullopt;
    const std::optional<bool> value = found->value_exact<bool>();
    if (!value)
        fault(key, "must be true or false, without quotes");
    return value;
}

std::vector<double> TomlTable::numbers(const std::string& key, const NumberRange& range) {
    const toml::node* found = ask(key);
    if (found == nullptr)
        return {};
    std::vector<double> values;
    const toml::array* array = found->as_array();
    bool right = array != nullptr && !array->empty();
    for (std::size_t i = 0; right && i < array->size(); ++i) {
        const auto value = (*array)[i].value<double>();
        right = (*array)[i].is_number() && value && range.contains(*value);
        if (right)
            values.push_back(*value);
    }
    if (right)
        return values;
    fault(key, fmt::format("must be a list, of which each {}", allowed_range(range)));
    return {};
}

std::vector<std::string> TomlTable::texts(const std::string& key) {
    const toml::node* found = ask(key);
    if (found == nullptr)
        return {};
    std::vector<std::string> values;
    const toml::array* array = found->as_array();
    for (std::size_t i = 0; array != nullptr && i < array->size(); ++i)
        if (auto value = (*array)[i].value_exact<std::string>())
            values.push_back(*value);
    if (array != nullptr && !array->empty() && values.size() == array->size())
        return values;
    fault(key, "must be a list of texts in quotes");
    return {};
}

std::string TomlTable::key_of(const std::string& name, const KeyUnit& unit) const {
    const std::string si = fmt::format("{}_{}", name, unit.si);
    return has(si) ? si : fmt::format("{}_{}", name, unit.small);
}

std::optional<double> TomlTable::quantity(const std::string& name, const KeyUnit& unit,
                                          const NumberRange& range) {
    const std::string small = fmt::format("{}_{}", name, unit.small);
    const std::string si = fmt::format("{}_{}", name, unit.si);
    const bool is_small = has(small) || !has(si);
    static_cast<void>(ask(small));
    static_cast<void>(ask(si));
    if (has(si) && has(small)) {
        fault(si, fmt::format("stands beside {}: one of them is enough", small));
        return std::nullopt;
    }
    const int power = is_small ? unit.power_of_ten : 0;
    const auto value =
        number(is_small ? small : si, {with_point_moved(range.low, -power),
                                       with_point_moved(range.high, -power), range.low_is_open});
    return value ? std::optional(with_point_moved(*value, power)) : std::nullopt;
}

double TomlTable::required_quantity(const std::string& name, const KeyUnit& unit,
                                    const NumberRange& range, std::string_view meaning) {
    const auto value = quantity(name, unit, range);
    missing(key_of(name, unit), meaning);
    return value.value_or(0.0);
}

std::optional<double> TomlTable::length(const std::string& name, const NumberRange& range) {
    return quantity(name, length_unit, range);
}

double TomlTable::required_length(const std::string& name, const NumberRange& range,
                                  std::string_view meaning) {
    return required_quantity(name, length_unit, range, meaning);
}

TomlTable TomlTable::table(const std::string& key) {
    const toml::node* found = ask(key);
    if (found != nullptr && !found->is_table())
        fault(key, fmt::format("must be a table: write [{}]", full_key(key)));
    return {found != nullptr ? found->as_table() : nullptr, full_key(key), *faults_};
}

std::vector<TomlTable> TomlTable::tables(const std::string& key) {
    const toml::node* found = ask(key);
    std::vector<TomlTable> tables;
    if (found == nullptr)
        return tables;
    const toml::array* array = found->as_array();
    if (array == nullptr || !array->is_array_of_tables()) {
        fault(key, fmt::format("must be a list of tables: write [[{}]]", full_key(key)));
        return tables;
    }
    for (const toml::node& element : *array)
        tables.emplace_back(element.as_table(), full_key(key), *faults_);
    return tables;
}

void TomlTable::missing(const std::string& key, std::string_view allowed) {
    if (!has(key))
        faults_->add(line(key), fmt::format("{} is missing: {}", full_key(key), allowed));
}

void TomlTable::fault(std::string_view key, std::string_view text) const {
    const toml::node* found = table_ != nullptr ? table_->get(key) : nullptr;
    const std::string value = found != nullptr ? " = " + value_text(*found) : "";
    faults_->add(line(key), fmt::format("{}{}: {}", full_key(key), value, text));
}

void TomlTable::finish(std::vector<std::string>& remarks) const {
    if (table_ == nullptr)
        return;
    for (const auto& [key, node] : *table_) {
        const std::string name(key.str());
        if (std::ranges::find(asked_, name) != asked_.end())
            continue;
        if (const std::string hint = unknown_key_hint(name); !hint.empty())
            faults_->add(key.source().begin.line,
                         fmt::format("{}: unknown key (did you mean {}?)", full_key(name), hint));
        else
            remarks.push_back(fmt::format("{}:{}: {} is not a key that culm knows; it is ignored",
                                          faults_->file(), key.source().begin.line,
                                          full_key(name)));
    }
}

const toml::node* TomlTable::ask(const std::string& key) {
    if (std::ranges::find(asked_, key) == asked_.end())
        asked_.push_back(key);
    return table_ != nullptr ? table_->get(key) : nullptr;
}

std::string TomlTable::full_key(std::string_view key) const {
    return name_.empty() ? std::string(key) : fmt::format("{}.{}", name_, key);
}

std::string TomlTable::unknown_key_hint(const std::string& key) const {
    for (const std::string& valid : asked_)
        if (quantity_of(valid) == quantity_of(key))
            return valid;
    // Stricter than a choice among words: a note of the laboratory's own is no misspelling.
    const std::string nearest = core::nearest_name(key, asked_);
    const std::size_t most = std::max<std::size_t>(1, key.size() / 4);
    return !nearest.empty() && core::edit_distance(key, nearest) <= most ? nearest : "";
}

} // namespace culm::measure
