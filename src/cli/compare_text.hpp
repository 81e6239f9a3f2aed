// SPDX-License-Identifier: BSD-3-Clause
// What culm compare prints, from what it writes.
#pragma once

#include "cli/text_style.hpp"

#include <string>

#include <nlohmann/json.hpp>

namespace culm::cli {

/// The ladder, its parameters, which steps are gains, and three sentences on the last model.
[[nodiscard]] std::string comparison_text(const nlohmann::json& comparison, const TextStyle& style);

/// Residual over noise of every model in every measurement; * stands for at most 1.10.
[[nodiscard]] std::string effect_table_text(const nlohmann::json& table, const TextStyle& style);

} // namespace culm::cli
