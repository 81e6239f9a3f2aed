// SPDX-License-Identifier: BSD-3-Clause
// The spread of b1 and b2 over a study's stems, and the factors that cause it.
#pragma once

#include "reduce/population_statistics.hpp"
#include "reduce/sensitivity.hpp"
#include "reduce/variance_components.hpp"
#include "study/execute/plan.hpp"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace culm::study {

/// Spread of one fitted quantity.
struct ResponseSpread {
    std::string name; ///< "decay_per_cycle" or "frequency", as the archive's columns
    std::string unit;
    reduce::SampleSummary population;
    std::optional<reduce::VarianceComponents> components; ///< of stems with several tests
    std::optional<reduce::Sensitivity> sensitivity;
};

/// Factors that depend on each other share one index; others are alone.
struct FactorGroup {
    std::string name; ///< the keys, joined by ", "
    std::vector<std::string> factors;
};

struct ReplicateSummary {
    std::vector<ResponseSpread> responses;
    std::vector<FactorGroup> groups;   ///< in the order of the sensitivities' groups
    bool has_distributions = false;    ///< does any factor describe a population?
    std::string no_sensitivity_reason; ///< one sentence, if there are none
};

/// Nothing for a study without factors. `decay_per_cycle` and `frequency` (Hz) have the shape
/// (points), NaN where there is no fit.
[[nodiscard]] std::optional<ReplicateSummary>
summarise_replicates(const Study& study, std::span<const double> decay_per_cycle,
                     std::span<const double> frequency);

} // namespace culm::study
