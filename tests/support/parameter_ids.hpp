// SPDX-License-Identifier: BSD-3-Clause
// Parameters from their printed names.
#pragma once

#include "physics/parameter_id.hpp"

#include <algorithm>
#include <string>

namespace culm::tests {

/// The parameter that physics::to_string writes as "tip_mass.mass_kg@S07".
[[nodiscard]] inline physics::ParameterId id(const std::string& text) {
    const std::size_t at = std::min(text.find('@'), text.size());
    const std::string of_model = text.substr(0, at);
    const std::size_t dot = of_model.find('.');
    physics::ParameterId found;
    found.effect = dot == std::string::npos ? "" : of_model.substr(0, dot);
    found.name = dot == std::string::npos ? of_model : of_model.substr(dot + 1);
    found.recording = at < text.size() ? text.substr(at + 1) : "";
    return found;
}

} // namespace culm::tests
