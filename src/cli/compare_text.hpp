// SPDX-License-Identifier: BSD-3-Clause
// What culm compare prints, from what it writes.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace culm::cli {

/// "1.9010 ± 0.0001" of a parameter, with half of the 95 % interval.
[[nodiscard]] std::string value_text(const nlohmann::json& parameter);

/// The ladder, its parameters, which steps are gains, and three sentences on the last model.
[[nodiscard]] std::string comparison_text(const nlohmann::json& comparison);

/// Residual over noise of every model in every measurement; * stands for at most 1.10.
[[nodiscard]] std::string effect_table_text(const nlohmann::json& table);

} // namespace culm::cli
