// SPDX-License-Identifier: BSD-3-Clause
// Results as files: text, JSON, and their folders.
#pragma once

#include "reduce/population_statistics.hpp"

#include <cmath>
#include <functional>
#include <optional>
#include <ranges>
#include <string>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace culm::present {

/// A number, or null for NaN and infinities, which JSON does not have.
[[nodiscard]] inline nlohmann::json number(double value) {
    return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

[[nodiscard]] inline nlohmann::json number(const std::optional<double>& value) {
    return value ? number(*value) : nlohmann::json(nullptr);
}

/// [lower, upper] of an interval, an estimate or a coefficient, each times `scale`.
[[nodiscard]] inline nlohmann::json bounds_json(const auto& interval, double scale = 1.0) {
    return nlohmann::json::array({number(scale * interval.lower), number(scale * interval.upper)});
}

/// {"value", "stderr", "interval"} of a number with its interval of 95 %, each times `scale`.
[[nodiscard]] inline nlohmann::json interval_json(const auto& found, double scale = 1.0) {
    return {{"value", number(scale * found.value)},
            {"stderr", number(scale * found.standard_error)},
            {"interval", bounds_json(found, scale)}};
}

/// Moments with their intervals and quantiles, each times `scale`.
[[nodiscard]] nlohmann::json sample_json(const reduce::SampleSummary& sample, double scale = 1.0);

/// A JSON array of `one(item)` for each item.
template <class Json = nlohmann::json, class Items, class One>
[[nodiscard]] Json array_of(const Items& items, const One& one) {
    Json out = Json::array();
    for (const auto& item : items)
        out.push_back(std::invoke(one, item));
    return out;
}

/// A JSON array of `one(k)` for k = 0 … count - 1.
template <class One>
[[nodiscard]] nlohmann::json array_of_count(std::size_t count, const One& one) {
    return array_of(std::views::iota(std::size_t{0}, count), one);
}

/// A cell of a CSV file after its comma; empty for NaN.
[[nodiscard]] inline std::string csv_cell(double value) {
    return std::isnan(value) ? std::string(",") : fmt::format(",{:.6g}", value);
}

/// Writes to the file, or to standard output for "-". Throws core::StorageError.
void write_json(const std::string& file, const nlohmann::json& json);

} // namespace culm::present
