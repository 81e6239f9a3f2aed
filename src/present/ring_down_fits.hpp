// SPDX-License-Identifier: BSD-3-Clause
// The results of culm fit: Eq. 1 at every height of measured stems (docs/fit-format.md).
#pragma once

#include "present/provenance.hpp"
#include "reduce/backbone/backbone.hpp"
#include "residuals/stem_ring_downs.hpp"

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace culm::present {

/// All results of `culm fit`.
struct FitReport {
    reduce::RingDownOptions options; ///< as requested; the offset may differ by stem
    std::vector<residuals::StemRingDowns> stems;
    std::vector<std::string> folders; ///< of the stems
    std::vector<bool> has_offset;     ///< of the stems
    /// (stems) if they were asked for; empty otherwise.
    std::vector<std::vector<reduce::ModeBackbone>> backbones;
    std::vector<std::optional<reduce::DampedModesFit>> modes;
    std::optional<residuals::PopulationSummary> population; ///< of two stems or more
    std::vector<std::string> remarks;
    Provenance provenance;
};

/// fit.json.
[[nodiscard]] nlohmann::json fit_json(const FitReport& report);
[[nodiscard]] nlohmann::json fit_schema();

/// A summary for one screen: the heights of one stem, or one line per stem and the population.
[[nodiscard]] std::string fit_table(const FitReport& report);

/// CSV: one line per stem and height.
[[nodiscard]] std::string fit_csv(const FitReport& report);

} // namespace culm::present
