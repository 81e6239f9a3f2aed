// SPDX-License-Identifier: BSD-3-Clause
// Results as files: JSON, and measured and modelled motion as a table (deflections.csv).
#pragma once

#include "fit/fit.hpp"
#include "measure/folder/measurement.hpp"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace culm::present {

/// A cell of a CSV file after its comma; empty for NaN.
[[nodiscard]] inline std::string csv_cell(double value) {
    return std::isnan(value) ? std::string(",") : fmt::format(",{:.6g}", value);
}

/// A column of the time, s, and for every height the measured deflection and each model's under its
/// label, mm: one line for each frame that the first model's fit used. Empty cells: not seen.
[[nodiscard]] std::string
deflections_csv(const measure::Measurement& measurement,
                const std::vector<std::pair<std::string, const fit::RecordingFit*>>& models);

/// Writes to the file, or to standard output for "-". Throws core::StorageError.
void write_json(const std::string& file, const nlohmann::json& json);

} // namespace culm::present
