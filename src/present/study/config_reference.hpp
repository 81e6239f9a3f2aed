// SPDX-License-Identifier: BSD-3-Clause
// The keys of study files as text, from the catalogue that their reader uses.
#pragma once

#include "study/config/keys.hpp"

#include <string>
#include <vector>

namespace culm::present {

/// Every table with the names of its keys.
[[nodiscard]] std::string config_key_list();

/// The allowed values and the default of each of the keys. A name is that of a table ("stem"), of a
/// key ("bond_damping") or of both ("law.name"). Throws core::InputError for unknown names.
[[nodiscard]] std::string config_key_cards(const std::vector<std::string>& names);

/// The tables in the order of the catalogue.
[[nodiscard]] std::vector<std::string> config_tables();

/// "a number in (0, 1000] mm; default 2.83".
[[nodiscard]] std::string key_value(const study::ConfigKey& key);

/// The key's description, without the Markdown backticks around names of other keys.
[[nodiscard]] std::string key_meaning(const study::ConfigKey& key);

} // namespace culm::present
