// SPDX-License-Identifier: BSD-3-Clause
#include "study/config/keys.hpp"

#include "core/nearest_name.hpp"
#include "core/toml/value.hpp"
#include "study/config/parameters.hpp"

#include <limits>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::study {

namespace {

std::string with_unit(const std::string& text, const std::string& unit) {
    return unit.empty() || unit == "as the parameter" ? text : text + " " + unit;
}

std::string number_in(const Interval& range, const std::string& unit) {
    if (range.high < std::numeric_limits<double>::max())
        return "number in " + with_unit(range.text(), unit);
    return range.low < 0.0 ? "number" : "number above 0";
}

} // namespace

std::string ConfigKey::allowed() const {
    switch (kind) {
    case ValueKind::Text:
        return "text";
    case ValueKind::Word:
        return core::one_of(words);
    case ValueKind::Number:
        return "a " + number_in(range, unit);
    case ValueKind::NumberOrWord:
        return fmt::format("a {} or {}", number_in(range, unit), core::one_of(words));
    case ValueKind::WholeNumber:
        return "a whole " + number_in(range, unit);
    case ValueKind::Tables:
        return "tables [[design.point]] with the same parameters in each";
    case ValueKind::WordList:
        return "a list of names";
    case ValueKind::Matrix:
        return "a square matrix [[…], …] of numbers in " + range.text();
    case ValueKind::NumberList:
        return "a list of numbers in " + with_unit(range.text(), unit);
    }
    return {};
}

std::vector<ConfigKey> config_keys_of(std::string_view section) {
    std::vector<ConfigKey> keys = config_keys();
    std::erase_if(keys, [&](const ConfigKey& key) { return key.section != section; });
    return keys;
}

std::string config_key_tables() {
    const auto or_dash = [](const std::string& s) { return s.empty() ? "–" : s.c_str(); };
    std::string text;
    std::string section;
    for (const ConfigKey& key : config_keys()) {
        if (key.section != section) {
            section = key.section;
            text += fmt::format("\n### `[{}]`\n\n| key | unit | default | allowed | meaning |\n"
                                "|---|---|---|---|---|\n",
                                section);
        }
        text += fmt::format("| `{}` | {} | {} | {} | {} |\n", key.key, or_dash(key.unit),
                            or_dash(key.default_text), key.allowed(), key.meaning);
    }
    return text;
}

namespace {

/// The hint for a key that names a valid quantity with another unit, or with none.
std::optional<std::string> unit_hint(const UnknownKey& unknown,
                                     std::span<const std::string> valid) {
    const KeyParts found = split_key(unknown.key);
    for (const std::string& key : valid) {
        const KeyParts right = split_key(key);
        // The same quantity in another unit: the key was meant.
        if (right.quantity != found.quantity || !right.unit)
            continue;
        if (!found.unit || found.unit->dimension != right.unit->dimension || !unknown.value)
            return fmt::format("unknown key: write {}, in {}", key, right.unit->name);
        // The value is converted too: with a new key alone the stem would change by powers of ten.
        const double converted = right.unit->from_si(found.unit->to_si(*unknown.value));
        return fmt::format("unknown key: the unit is {} (write {} = {:.12g})", right.unit->name,
                           key, converted);
    }
    return std::nullopt;
}

} // namespace

std::string unknown_key_hint(const UnknownKey& unknown, std::span<const std::string> valid) {
    for (const ConfigKey& key : config_keys())
        // A key in the wrong table is the likeliest mistake and has one correction, so it is
        // checked first.
        if (key.key == unknown.key && key.section.find('<') == std::string::npos)
            return fmt::format("unknown key: it belongs into [{}]", key.section);
    if (auto hint = unit_hint(unknown, valid))
        return *hint;
    const std::string guess = did_you_mean(unknown.key, valid);
    if (!guess.empty())
        return "unknown key" + guess;
    return fmt::format("unknown key: must be one of {}", fmt::join(valid, ", "));
}

std::string did_you_mean(std::string_view name, std::span<const std::string> valid,
                         std::string_view quote) {
    const std::string nearest = core::nearest_name(name, valid);
    return nearest.empty() ? "" : fmt::format(" (did you mean {0}{1}{0}?)", quote, nearest);
}

} // namespace culm::study
