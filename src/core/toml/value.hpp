// SPDX-License-Identifier: BSD-3-Clause
// Parses TOML and formats its values for messages.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <toml++/toml.h>

namespace culm::core {

/// Parses a text; `file` is its name in messages. Throws core::InputError with file, line and
/// column.
[[nodiscard]] toml::table parse_toml_text(std::string_view text, const std::string& file);

/// "a" or "b"; "a", "b" or "c".
[[nodiscard]] std::string one_of(std::span<const std::string> words);

/// The value as a person would write it, shortened if it is long.
[[nodiscard]] std::string value_text(const toml::node& node);

/// The number as written in the text that it was parsed from.
[[nodiscard]] std::string_view written_text(const toml::node& node, std::string_view text);

/// The unit of the last digit: 0.001 for "0.050", 100 for "1.5e3".
[[nodiscard]] double last_digit(std::string_view number);

[[nodiscard]] inline std::size_t line_of(const toml::node& node) {
    return node.source().begin.line;
}

/// One key of a table.
struct TomlEntry {
    std::string key;
    const toml::node* node = nullptr;
    std::size_t line = 0;
};
/// Keys in the order of the file; toml++ sorts them by name.
[[nodiscard]] std::vector<TomlEntry> entries_in_order(const toml::table& table);

} // namespace culm::core
