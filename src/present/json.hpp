// SPDX-License-Identifier: BSD-3-Clause
// Results as JSON files.
#pragma once

#include "core/error.hpp"

#include <cmath>
#include <fstream>
#include <string>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace culm::present {

/// A number, or null where JSON has none: NaN and infinities.
[[nodiscard]] inline nlohmann::json number(double value) {
    return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

/// Writes to the file, or to standard output for "-". Throws core::StorageError.
inline void write_json(const std::string& file, const nlohmann::json& json) {
    // Names from damaged or foreign files need not be UTF-8.
    const std::string text = json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
    if (file == "-") {
        fmt::print("{}\n", text);
        return;
    }
    std::ofstream out(file);
    out << text << '\n';
    out.flush();
    if (!out)
        throw core::StorageError(fmt::format("{}: cannot be written", file));
}

} // namespace culm::present
