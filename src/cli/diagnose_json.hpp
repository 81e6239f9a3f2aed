// SPDX-License-Identifier: BSD-3-Clause
// diagnosis.json: what culm diagnose found (docs/diagnosis.md).
#pragma once

#include "diagnose/diagnosis.hpp"
#include "measure/folder/measurement.hpp"

#include <span>

#include <nlohmann/json.hpp>

namespace culm::cli {

/// `candidates` are those that were tried, for what is said of them.
[[nodiscard]] nlohmann::json diagnosis_json(const diagnose::Diagnosis& diagnosis,
                                            std::span<const measure::Measurement> recordings,
                                            const fit::SelectedEffects& candidates);

} // namespace culm::cli
