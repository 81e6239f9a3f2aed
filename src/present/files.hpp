// SPDX-License-Identifier: BSD-3-Clause
// Results as files: text, JSON, and their folders.
#pragma once

#include "core/describe.hpp"

#include <cmath>
#include <string>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace culm::present {

using core::json_of;
using core::number;

/// A cell of a CSV file after its comma; empty for NaN.
[[nodiscard]] inline std::string csv_cell(double value) {
    return std::isnan(value) ? std::string(",") : fmt::format(",{:.6g}", value);
}

/// Writes to the file, or to standard output for "-". Throws core::StorageError.
void write_json(const std::string& file, const nlohmann::json& json);

} // namespace culm::present
