// SPDX-License-Identifier: BSD-3-Clause
// The keys of study files as text, from the catalogue that their reader uses.
#pragma once

#include <string>
#include <vector>

namespace culm::present {

/// Every table with the names of its keys.
[[nodiscard]] std::string config_key_list();

/// The allowed values and the default of each of the keys. A name is that of a table ("stem"), of a
/// key ("bond_damping") or of both ("law.name"). Throws core::InputError for unknown names.
[[nodiscard]] std::string config_key_cards(const std::vector<std::string>& names);

} // namespace culm::present
