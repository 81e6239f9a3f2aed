// SPDX-License-Identifier: BSD-3-Clause
// The part of the catalogue that says what varies in a study, and how.
#pragma once

#include "study/config_keys.hpp"

#include <vector>

namespace culm::study {

/// Of one factor's table.
[[nodiscard]] std::vector<ConfigKey> factor_keys();

/// Of [design], [replicates] and [correlation].
[[nodiscard]] std::vector<ConfigKey> design_keys();

} // namespace culm::study
