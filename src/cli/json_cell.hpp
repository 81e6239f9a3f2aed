// SPDX-License-Identifier: BSD-3-Clause
// Members of a result as the cells of printed tables.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

namespace culm::cli {

/// NaN for what is no number.
[[nodiscard]] inline double number_in_json(const nlohmann::json& value) {
    return value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN();
}

/// "-" for what is no number.
[[nodiscard]] inline std::string json_cell(const nlohmann::json& value, int decimals) {
    return value.is_number() ? fmt::format("{:.{}f}", value.get<double>(), decimals)
                             : std::string("-");
}

/// An array of names as one text.
[[nodiscard]] inline std::string joined(const nlohmann::json& names, const char* between) {
    return fmt::format("{}", fmt::join(names.get<std::vector<std::string>>(), between));
}

} // namespace culm::cli
