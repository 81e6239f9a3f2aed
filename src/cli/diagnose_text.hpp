// SPDX-License-Identifier: BSD-3-Clause
// What culm diagnose prints, from what it writes.
#pragma once

#include "cli/text_style.hpp"

#include <string>

#include <nlohmann/json.hpp>

namespace culm::cli {

/// The verdict in plain words, the ladder, the best candidates, blind spots, false naming, the next
/// experiments; a screenful. `next_command` is printed as the last line.
[[nodiscard]] std::string diagnosis_text(const nlohmann::json& diagnosis,
                                         const std::string& next_command, const TextStyle& style);

} // namespace culm::cli
