// SPDX-License-Identifier: BSD-3-Clause
#include "cli/parameter_text.hpp"

#include "cli/json_cell.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace culm::cli {

ReadableParameter readable(const std::string& key, double value) {
    const std::size_t at = std::min(key.find('@'), key.size());
    const std::string_view quantity = std::string_view(key).substr(0, at);
    const auto as = [&](std::string_view name, double scale, std::string_view unit) {
        return ReadableParameter{std::string(name) + key.substr(at), scale, unit};
    };
    if (quantity == "bond_youngs_modulus_pa")
        return value < 1e8 ? as("bond_youngs_modulus", 1e-6, "MPa")
                           : as("bond_youngs_modulus", 1e-9, "GPa");
    if (quantity == "tip_deflection_m")
        return as("tip_deflection", 1e3, "mm");
    if (quantity == "release_time_s")
        return as("release_time", 1e3, "ms");
    return as(quantity, 1.0, "");
}

std::string value_text(const std::string& key, const nlohmann::json& parameter) {
    const ReadableParameter shown = readable(key, number_in_json(parameter["value"]));
    const double value = shown.scale * number_in_json(parameter["value"]);
    const double half = shown.scale * number_in_json(parameter["interval"][1]) - value;
    const bool is_known = std::isfinite(half) && half > 0.0;
    const int digits =
        is_known
            ? std::clamp(static_cast<int>(std::ceil(std::log10(std::abs(value) / half))) + 2, 3, 7)
            : 5;
    std::string text = fmt::format("{:.{}g}", value, digits);
    if (is_known)
        text += fmt::format(" ± {:.2g}", half);
    if (!shown.unit.empty())
        text += fmt::format(" {}", shown.unit);
    return text + (parameter["at_bound"].get<bool>() ? "  (at its bound)" : "");
}

} // namespace culm::cli
