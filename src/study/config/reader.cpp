// SPDX-License-Identifier: BSD-3-Clause
#include "study/config/reader.hpp"

#include "core/error.hpp"
#include "study/config/keys.hpp"

#include <algorithm>
#include <sstream>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::study {

void ConfigErrors::add(std::size_t line, std::string_view text) {
    errors_.push_back({line, fmt::format("{}:{}: {}", file_, line, text)});
}

void ConfigErrors::add(std::size_t line, std::string_view key, std::string_view value,
                       std::string_view allowed) {
    add(line, fmt::format("{} = {}: {}", key, value, allowed));
}

void ConfigErrors::throw_if_any() const {
    if (errors_.empty())
        return;
    auto ordered = errors_;
    std::ranges::stable_sort(ordered, {}, &Error::line);
    std::string text;
    for (const Error& error : ordered)
        text += (text.empty() ? "" : "\n") + error.text;
    throw core::InputError(text);
}

namespace {

std::vector<std::string> names_of(const std::vector<ConfigKey>& keys) {
    std::vector<std::string> names;
    names.reserve(keys.size());
    for (const ConfigKey& key : keys)
        names.push_back(key.key);
    return names;
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
        for (const TableEntry& entry : entries_in_order(*table))
            parts.push_back(fmt::format("{} = {}", entry.key, full_text(*entry.node)));
        return fmt::format("{{ {} }}", fmt::join(parts, ", "));
    }
    std::ostringstream stream; // truth values, dates and times
    node.visit([&](const auto& value) { stream << toml::toml_formatter{value}; });
    return stream.str();
}

} // namespace

std::string value_text(const toml::node& node) {
    const std::string text = full_text(node);
    constexpr std::size_t longest = 60;
    return text.size() > longest ? text.substr(0, longest) + " ..." : text;
}

std::vector<TableEntry> entries_in_order(const toml::table& table) {
    std::vector<std::pair<toml::source_position, TableEntry>> found;
    for (const auto& [key, node] : table)
        found.emplace_back(key.source().begin,
                           TableEntry{std::string(key.str()), &node, key.source().begin.line});
    std::ranges::sort(found, [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<TableEntry> entries;
    entries.reserve(found.size());
    for (auto& [position, entry] : found)
        entries.push_back(std::move(entry));
    return entries;
}

TableReader::TableReader(const toml::table* table, std::string prefix, std::string_view section,
                         ConfigErrors& errors)
    : table_(table), prefix_(std::move(prefix)), keys_(config_keys_of(section)), errors_(&errors) {}

void TableReader::refuse_unknown_keys() const {
    if (table_ == nullptr)
        return;
    const std::vector<std::string> valid = names_of(keys_);
    for (const TableEntry& entry : entries_in_order(*table_))
        if (std::ranges::find(valid, entry.key) == valid.end())
            errors_->add(
                entry.line, prefix_ + "." + entry.key, value_text(*entry.node),
                unknown_key_hint({prefix_, entry.key, entry.node->value<double>()}, valid));
}

bool TableReader::has(std::string_view key) const {
    return node(key) != nullptr;
}

std::size_t TableReader::line(std::string_view key) const {
    if (const toml::node* found = node(key))
        return line_of(*found);
    return table_ != nullptr ? line_of(*table_) : 1;
}

std::optional<std::string> TableReader::text(std::string_view key) const {
    const toml::node* found = node(key);
    if (found == nullptr)
        return std::nullopt;
    auto value = found->value_exact<std::string>();
    if (!value || value->empty()) {
        error(key, "must be " + description(key).allowed());
        return std::nullopt;
    }
    return value;
}

std::optional<std::string> TableReader::word(std::string_view key) const {
    const toml::node* found = node(key);
    if (found == nullptr)
        return std::nullopt;
    auto value = found->value_exact<std::string>();
    const ConfigKey& wanted = description(key);
    if (value && std::ranges::find(wanted.words, *value) != wanted.words.end())
        return value;
    error(key,
          "must be " + wanted.allowed() + (value ? did_you_mean(*value, wanted.words, "\"") : ""));
    return std::nullopt;
}

std::optional<double> TableReader::number(std::string_view key) const {
    const toml::node* found = node(key);
    if (found == nullptr)
        return std::nullopt;
    const ConfigKey& wanted = description(key);
    const bool right_type =
        wanted.kind == ValueKind::WholeNumber ? found->is_integer() : found->is_number();
    if (const auto value = found->value<double>(); right_type && wanted.range.contains(*value))
        return value;
    error(key, "must be " + wanted.allowed());
    return std::nullopt;
}

std::optional<std::int64_t> TableReader::whole_number(std::string_view key) const {
    // The ranges of whole numbers end at 2⁵³ at most, so that nothing is lost on the way.
    if (const auto value = number(key))
        return static_cast<std::int64_t>(*value);
    return std::nullopt;
}

std::optional<std::vector<double>> TableReader::numbers(std::string_view key) const {
    const toml::node* found = node(key);
    if (found == nullptr)
        return std::nullopt;
    const ConfigKey& wanted = description(key);
    std::vector<double> values;
    const toml::array* array = found->as_array();
    bool right = array != nullptr && !array->empty();
    for (std::size_t i = 0; right && i < array->size(); ++i) {
        const toml::node& element = (*array)[i];
        right = element.is_number() && wanted.range.contains(*element.value<double>());
        if (right)
            values.push_back(*element.value<double>());
    }
    if (right)
        return values;
    error(key, "must be " + wanted.allowed());
    return std::nullopt;
}

void TableReader::error(std::string_view key, std::string_view allowed) const {
    const std::string full_key = fmt::format("{}.{}", prefix_, key);
    if (const toml::node* found = node(key))
        errors_->add(line_of(*found), full_key, value_text(*found), allowed);
    else
        errors_->add(line(key), fmt::format("{} is missing: {}", full_key, allowed));
}

const toml::node* TableReader::node(std::string_view key) const {
    return table_ != nullptr ? table_->get(key) : nullptr;
}

const ConfigKey& TableReader::description(std::string_view key) const {
    const auto found = std::ranges::find(keys_, key, &ConfigKey::key);
    if (found == keys_.end())
        throw std::logic_error(fmt::format("the catalogue has no key {}.{}", prefix_, key));
    return *found;
}

} // namespace culm::study
