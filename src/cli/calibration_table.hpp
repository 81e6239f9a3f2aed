// SPDX-License-Identifier: BSD-3-Clause
// What culm calibrate shows on the screen, from what it writes to files.
#pragma once

#include "cli/text_style.hpp"

#include <string>

#include <nlohmann/json.hpp>

namespace culm::cli {

/// One stem in some lines, several as a table with what they say of the population.
[[nodiscard]] std::string calibration_table(const nlohmann::json& document, const TextStyle& style);

} // namespace culm::cli
