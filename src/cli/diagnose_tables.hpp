// SPDX-License-Identifier: BSD-3-Clause
// The tables below the verdict of culm diagnose; each takes diagnosis.json.
#pragma once

#include "cli/text_style.hpp"

#include <cstddef>
#include <string>

#include <nlohmann/json.hpp>

namespace culm::cli {

inline constexpr std::size_t diagnosis_width = 96; ///< characters of a line of running text

/// Has the blind spot a size from which on it would show?
[[nodiscard]] bool is_visible(const nlohmann::json& blind_spot);

[[nodiscard]] std::string error_ladder_lines(const nlohmann::json& found, const TextStyle& style);
[[nodiscard]] std::string ranking_lines(const nlohmann::json& found);
[[nodiscard]] std::string blind_spot_lines(const nlohmann::json& found);
[[nodiscard]] std::string false_naming_line(const nlohmann::json& found);
[[nodiscard]] std::string experiment_lines(const nlohmann::json& found);

} // namespace culm::cli
