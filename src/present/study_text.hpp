// SPDX-License-Identifier: BSD-3-Clause
// What a study found as text: regressions, spread, limits of the time step, a repetition.
#pragma once

#include "study/execute/repetition.hpp"
#include "study/summary/summary.hpp"
#include "study/summary/timestep_summary.hpp"

#include <string>

namespace culm::present {

/// The two laws of the paper with their intervals beside the published figures, the terms that the
/// F-tests kept, the residuals, the spread of a study with distributions (stem to stem and within
/// stems, and the factors that it comes from), and the failed points.
[[nodiscard]] std::string regression_table(const study::StudySummary& summary);

/// The bisected limits beside the linearised ones and the authors' rule, the laws of the limit, the
/// errors of smaller steps, and the failed points.
[[nodiscard]] std::string timestep_table(const study::TimestepSummary& summary);

/// What a repetition was compared with, and what differs.
[[nodiscard]] std::string repetition_text(const study::Repetition& repetition);

} // namespace culm::present
