// SPDX-License-Identifier: BSD-3-Clause
// The results of culm diagnose for several specimens (docs/laboratory.md).
#pragma once

#include "diagnose/diagnosis.hpp"
#include "present/text_style.hpp"

#include <span>
#include <string>

#include <nlohmann/json_fwd.hpp>

namespace culm::present {

/// Effects of rigs with their values, one or some lines for each.
[[nodiscard]] std::string rig_effects_text(std::span<const diagnose::EffectAnswer> effects);
[[nodiscard]] nlohmann::json rig_effects_json(std::span<const diagnose::EffectAnswer> effects);

/// docs/schemas/laboratory.schema.json, except options, folders and provenance.
[[nodiscard]] nlohmann::json laboratory_json(const diagnose::Diagnosis& laboratory);

/// The verdict, the effects, Y and β over the stems, and the remarkable stems. `with_details`: also
/// the table of all stems and of the fitted models.
[[nodiscard]] std::string laboratory_text(const diagnose::Diagnosis& laboratory, bool with_details,
                                          const TextStyle& style);

} // namespace culm::present
