// SPDX-License-Identifier: BSD-3-Clause
// The keys of study files for people and for man(1), from the catalogue that their reader uses.
#pragma once

#include <string>
#include <vector>

namespace culm::cli {

/// Every table with the names of its keys.
[[nodiscard]] std::string config_key_list();

/// What each of the keys may be, and what it is when left out. A name is that of a table ("stem"),
/// of a key ("bond_damping") or both ("law.name"). Throws core::InputError for any other.
[[nodiscard]] std::string config_key_cards(const std::vector<std::string>& names);

/// culm-config(5), roff with the man macros; `version` stands in its foot.
[[nodiscard]] std::string config_manual_page(const std::string& version);

} // namespace culm::cli
