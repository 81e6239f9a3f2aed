// SPDX-License-Identifier: BSD-3-Clause
// A time-step study's findings as text.
#pragma once

#include "study/timestep_summary.hpp"

#include <string>

namespace culm::cli {

/// The bisected limits beside the linearised ones and the authors' rule, the laws of the limit, the
/// errors of smaller steps, and the failed points.
[[nodiscard]] std::string timestep_table(const study::TimestepSummary& summary);

} // namespace culm::cli
