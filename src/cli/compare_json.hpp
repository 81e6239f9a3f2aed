// SPDX-License-Identifier: BSD-3-Clause
// comparison.json: what culm compare found (docs/compare.md).
#pragma once

#include "diagnose/effect_table.hpp"
#include "diagnose/ladder.hpp"

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace culm::cli {

/// One comparison; `of` is its fit. The member "where" of a rung.
[[nodiscard]] nlohmann::json where_json(const diagnose::Comparison& comparison,
                                        const fit::RecordingFit& of);

/// All rungs with what each leaves, and the verdict on the last.
[[nodiscard]] nlohmann::json ladder_json(const diagnose::Ladder& ladder,
                                         const measure::Measurement& measurement);

[[nodiscard]] nlohmann::json cell_json(const diagnose::EffectCell& cell);

/// bond_youngs_modulus_pa, tip_deflection_m, …; effects' parameters have their unit in their name.
/// One that belongs to one of several recordings ends in an at sign and its id:
/// `tip_deflection_m@S01`.
[[nodiscard]] std::string parameter_key(const fit::FittedParameter& parameter);

/// By parameter_key().
[[nodiscard]] nlohmann::json parameters_json(const std::vector<fit::FittedParameter>& parameters);

} // namespace culm::cli
