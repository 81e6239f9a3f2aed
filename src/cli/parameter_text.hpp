// SPDX-License-Identifier: BSD-3-Clause
// Fitted parameters of a JSON document in units that suit a stem.
#pragma once

#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

namespace culm::cli {

/// What a parameter is called on the screen, and its unit there.
struct ReadableParameter {
    std::string name;        ///< the key without the unit in it: "tip_deflection@T2"
    double scale = 1.0;      ///< from the unit of the document
    std::string_view unit{}; ///< empty: none, or the name tells it (tip_mass.mass_kg)
};

/// Young's modulus in MPa or GPa, as its value calls for; deflections in mm, times in ms.
[[nodiscard]] ReadableParameter readable(const std::string& key, double value);

/// "1.90173 ± 0.00065 GPa": value and half of its 95 % interval, as many digits as that leaves
/// sure.
[[nodiscard]] std::string value_text(const std::string& key, const nlohmann::json& parameter);

} // namespace culm::cli
