// SPDX-License-Identifier: BSD-3-Clause
// The uncertainty budget of a calibration, for people and for programs (docs/uncertainty.md).
#pragma once

#include "fit/solve/uncertainty_budget.hpp"
#include "present/text_style.hpp"

#include <span>
#include <string>

#include <nlohmann/json.hpp>

namespace culm::present {

/// A table: every input with its standard uncertainty, its pull, and what it adds to Y, β and the
/// effects' numbers; below it what the defaults are, and which statements the readings contradict.
[[nodiscard]] std::string budget_text(const fit::UncertaintyBudget& budget,
                                      std::span<const fit::FittedParameter> parameters,
                                      const TextStyle& style);

/// {"inputs": [{"name", "unit", "value", "standard_uncertainty", "default", "pull",
/// "uncertainty_with_readings", "sensitivities", "shares"}], "readings": {"standard_uncertainties",
/// "shares"}, "combined", "sentences"}; maps are by parameter_key().
[[nodiscard]] nlohmann::json budget_json(const fit::UncertaintyBudget& budget,
                                         std::span<const fit::FittedParameter> parameters);

} // namespace culm::present
