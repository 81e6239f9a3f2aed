// SPDX-License-Identifier: BSD-3-Clause
// Result of a case: sampled histories and the cost, or the reason of a failure.
#pragma once

#include "core/error.hpp"
#include "integrate/solve_summary.hpp"

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace culm::run {

/// Histories are sampled at k · sample_interval, k = 0 … sample_count − 1. The lateral direction is
/// that of the pull; deflections are metres from the undeformed straight axis.
struct CaseResult {
    std::vector<double> tip_deflection;    ///< (samples); always filled
    std::vector<double> height_deflection; ///< (samples, heights), row-major
    std::vector<double> positions;         ///< (samples, spheres, 3), row-major: axial, lateral,
                                           ///< out of plane; only for StoreLevel::Full
    integrate::SolveSummary work;          ///< of the integrator
    double wall_seconds = 0.0;             ///< of the case; of its share when lanes ran together
};

struct CaseFailure {
    core::FailureKind kind = core::FailureKind::NotANumber;
    std::string reason; ///< one sentence, with the time and the value at which it failed
};

using CaseOutcome = std::variant<CaseResult, CaseFailure>;

} // namespace culm::run
