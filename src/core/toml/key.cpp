// SPDX-License-Identifier: BSD-3-Clause
#include "core/toml/key.hpp"

#include "core/toml/value.hpp"

#include <limits>
#include <string>

#include <fmt/format.h>

namespace culm::core {

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

std::string KeyDescription::allowed() const {
    switch (kind) {
    case ValueKind::Text:
        return "text";
    case ValueKind::Word:
        return one_of(words);
    case ValueKind::Number:
        return "a " + number_in(range, unit);
    case ValueKind::WholeNumber:
        return "a whole " + number_in(range, unit);
    case ValueKind::Tables:
        return fmt::format("tables [[{}.{}]] with the same parameters in each", table, name);
    case ValueKind::WordList:
        return "a list of names";
    case ValueKind::NumberList:
        return "a list of numbers in " + with_unit(range.text(), unit);
    }
    return {};
}

std::string markdown_tables(const std::vector<KeyDescription>& keys) {
    const auto or_dash = [](const std::string& s) { return s.empty() ? "–" : s.c_str(); };
    std::string text;
    std::string table;
    for (const KeyDescription& key : keys) {
        if (key.table != table) {
            table = key.table;
            text += fmt::format("\n### `[{}]`\n\n| key | unit | default | allowed | meaning |\n"
                                "|---|---|---|---|---|\n",
                                table);
        }
        text += fmt::format("| `{}` | {} | {} | {} | {} |\n", key.name, or_dash(key.unit),
                            or_dash(key.default_text), key.allowed(), key.meaning);
    }
    return text;
}

} // namespace culm::core
