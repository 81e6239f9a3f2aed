// SPDX-License-Identifier: BSD-3-Clause
// The keys of study files as text, from the catalogue that their reader uses.
#pragma once

#include "study/config/keys.hpp"

#include <string>
#include <vector>

namespace culm::present {

/// Every table with the names of its keys.
[[nodiscard]] std::string config_key_list();

/// What each of the keys may be, and what it is when left out. A name is that of a table ("stem"),
/// of a key ("bond_damping") or both ("law.name"). Throws core::InputError for any other.
[[nodiscard]] std::string config_key_cards(const std::vector<std::string>& names);

/// The tables in the order of the catalogue.
[[nodiscard]] std::vector<std::string> config_tables();

/// "a number in (0, 1000] mm; default 2.83".
[[nodiscard]] std::string key_value(const study::ConfigKey& key);

/// Without the backticks in which its text names other keys, as in Markdown.
[[nodiscard]] std::string key_meaning(const study::ConfigKey& key);

} // namespace culm::present
