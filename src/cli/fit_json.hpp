// SPDX-License-Identifier: BSD-3-Clause
// The laboratory results as JSON (docs/fit-format.md).
#pragma once

#include "reduce/stem_ring_downs.hpp"

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace culm::cli {

/// Everything that `culm fit` found.
struct FitReport {
    reduce::RingDownAnalysisOptions options; ///< as asked for; the offset may differ by stem
    std::vector<reduce::StemRingDowns> stems;
    std::vector<std::string> folders;                    ///< of the stems
    std::vector<bool> has_offset;                        ///< of the stems
    std::optional<reduce::PopulationSummary> population; ///< of two stems or more
    std::vector<std::string> remarks;
};

[[nodiscard]] nlohmann::json fit_json(const FitReport& report);

} // namespace culm::cli
