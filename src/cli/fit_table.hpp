// SPDX-License-Identifier: BSD-3-Clause
// The laboratory results as text for a screen and as a table of all heights.
#pragma once

#include "cli/fit_json.hpp"
#include "cli/text_style.hpp"

#include <string>

namespace culm::cli {

/// A summary that fits a screen: the heights of one stem, or one line per stem and the population.
[[nodiscard]] std::string fit_table(const FitReport& report, const TextStyle& style);

/// CSV: one line per stem and height.
[[nodiscard]] std::string fit_csv(const FitReport& report);

} // namespace culm::cli
