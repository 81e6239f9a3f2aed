// SPDX-License-Identifier: BSD-3-Clause
// The pieces of summary.json.
#pragma once

#include "reduce/study_regression.hpp"
#include "study/summary.hpp"

#include <nlohmann/json.hpp>

namespace culm::study {

/// A number, or null where JSON has none: NaN and infinities.
[[nodiscard]] nlohmann::json number_json(double value);

/// A regression's coefficient: term, coefficient, standard_error, interval, p_value.
[[nodiscard]] nlohmann::json term_json(const reduce::Coefficient& coefficient);

/// One response: its single-predictor law and the terms that the F-tests kept, or {"reason": …}.
[[nodiscard]] nlohmann::json to_json(const reduce::RegressionOutcome& outcome,
                                     const char* predictor, const char* unit);

} // namespace culm::study
