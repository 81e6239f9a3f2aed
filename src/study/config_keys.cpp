// SPDX-License-Identifier: BSD-3-Clause
#include "study/config_keys.hpp"

#include <limits>

#include <fmt/format.h>

namespace culm::study {

namespace {

std::string one_of(const std::vector<std::string>& words) {
    std::string text;
    for (std::size_t i = 0; i < words.size(); ++i) {
        const char* separator = i == 0 ? "" : i + 1 == words.size() ? " or " : ", ";
        text += fmt::format("{}\"{}\"", separator, words[i]);
    }
    return text;
}

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
        return one_of(words);
    case ValueKind::Number:
        return "a " + number_in(range, unit);
    case ValueKind::NumberOrWord:
        return fmt::format("a {} or {}", number_in(range, unit), one_of(words));
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

} // namespace culm::study
