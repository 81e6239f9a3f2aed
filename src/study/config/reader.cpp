// SPDX-License-Identifier: BSD-3-Clause
#include "study/config/keys.hpp"
#include "study/config/sections.hpp"

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

namespace culm::study {

TableReader::TableReader(const toml::table* table, std::string prefix, std::string_view section,
                         core::FileFaults& errors)
    : content_(table), table_(table, prefix, errors), prefix_(std::move(prefix)),
      keys_(config_keys_of(section)), errors_(&errors) {}

void TableReader::refuse_unknown_keys() const {
    if (content_ == nullptr)
        return;
    std::vector<std::string> valid;
    std::ranges::transform(keys_, std::back_inserter(valid), &ConfigKey::key);
    for (const core::TomlEntry& entry : entries_in_order(*content_))
        if (std::ranges::find(valid, entry.key) == valid.end())
            errors_->add(
                entry.line, prefix_ + "." + entry.key, value_text(*entry.node),
                unknown_key_hint({prefix_, entry.key, entry.node->value<double>()}, valid));
}

bool TableReader::has(std::string_view key) const {
    return table_.has(key);
}

std::size_t TableReader::line(std::string_view key) const {
    return table_.exists() ? table_.line(key) : 1;
}

std::optional<std::string> TableReader::text(std::string_view key) const {
    // An absent key is not passed on: the default belongs to the caller.
    return has(key) ? table_.text(std::string(key), description(key).allowed()) : std::nullopt;
}

std::optional<std::string> TableReader::word(std::string_view key) const {
    if (!has(key))
        return std::nullopt;
    const ConfigKey& wanted = description(key);
    if (const auto index = table_.word(std::string(key), wanted.words, wanted.allowed()))
        return wanted.words[*index];
    return std::nullopt;
}

std::optional<double> TableReader::number(std::string_view key) const {
    if (!has(key))
        return std::nullopt;
    const ConfigKey& wanted = description(key);
    if (wanted.kind != ValueKind::WholeNumber)
        return table_.number(wanted.key, wanted.range, wanted.allowed());
    // The ranges of whole numbers end at 2⁵³ at most, so the conversion is exact.
    if (const auto value = table_.whole_number(wanted.key, wanted.range, wanted.allowed()))
        return static_cast<double>(*value);
    return std::nullopt;
}

std::optional<std::int64_t> TableReader::whole_number(std::string_view key) const {
    if (const auto value = number(key))
        return static_cast<std::int64_t>(*value);
    return std::nullopt;
}

std::optional<std::vector<double>> TableReader::numbers(std::string_view key) const {
    if (!has(key))
        return std::nullopt;
    const ConfigKey& wanted = description(key);
    std::vector<double> values = table_.numbers(wanted.key, wanted.range, wanted.allowed());
    return values.empty() ? std::nullopt : std::optional(std::move(values));
}

void TableReader::error(std::string_view key, std::string_view allowed) const {
    if (has(key))
        table_.fault(key, allowed);
    else
        errors_->add(line(key), fmt::format("{}.{} is missing: {}", prefix_, key, allowed));
}

const ConfigKey& TableReader::description(std::string_view key) const {
    const auto found = std::ranges::find(keys_, key, &ConfigKey::key);
    if (found == keys_.end())
        throw std::logic_error(fmt::format("the catalogue has no key {}.{}", prefix_, key));
    return *found;
}

} // namespace culm::study
