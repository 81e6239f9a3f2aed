// SPDX-License-Identifier: BSD-3-Clause
// A study's regressions as text.
#pragma once

#include "study/summary.hpp"

#include <string>

namespace culm::cli {

/// The two laws of the paper with their intervals beside the published figures, the terms that the
/// F-tests kept, the residuals, and the failed points.
[[nodiscard]] std::string regression_table(const study::StudySummary& summary);

} // namespace culm::cli
