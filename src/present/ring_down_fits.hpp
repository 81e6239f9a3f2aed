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

struct FittedStem {
    residuals::StemRingDowns ring_downs;
    std::string folder;
    bool has_offset = false;
    std::vector<reduce::ModeBackbone> backbones;
    std::optional<reduce::DampedModesFit> modes;
};

/// All results of `culm fit`.
struct FitReport {
    reduce::RingDownOptions options; ///< as requested; the offset may differ by stem
    bool has_backbones = false;      ///< were they asked for?
    bool has_modes = false;          ///< likewise, modes that are fitted together
    std::vector<FittedStem> stems;
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
