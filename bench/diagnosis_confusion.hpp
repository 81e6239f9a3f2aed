// SPDX-License-Identifier: BSD-3-Clause
// What was said of which hidden effect, as a Markdown table.
#pragma once

#include "bench/diagnosis_score.hpp"

#include <string>
#include <vector>

namespace culm::bench {

/// Rows: the hidden effects, numbered. Columns: the same effects named with confidence, in their
/// numbers; then a tie that holds the truth, one that does not, several names, adequate, unknown
/// and no answer. Only recordings that hide one effect of the library count; empty if there are
/// none.
[[nodiscard]] std::string confusion_matrix(const std::vector<GradedCase>& cases);

} // namespace culm::bench
