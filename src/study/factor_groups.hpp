// SPDX-License-Identifier: BSD-3-Clause
// The factors of a study as independent groups with their joint distributions.
#pragma once

#include "reduce/sensitivity.hpp"
#include "study/plan.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace culm::study {

/// Places of the factors in StudyConfig::factors, group by group in the order of the first of each:
/// correlated factors belong together, and columns whose rows stay together.
[[nodiscard]] std::vector<std::vector<std::size_t>> dependent_factors(const StudyConfig& config);

/// The group's values at these points and its distribution: levels with equal weights, rows of the
/// table, quadrature nodes of a single distribution, a Sobol sample of correlated ones; of factors
/// that scatter within stems the design's own rows. Lognormal and log-uniform factors as
/// logarithms.
[[nodiscard]] reduce::InputGroup input_group(const Study& study,
                                             const std::vector<std::size_t>& factors,
                                             std::span<const std::int64_t> points);

} // namespace culm::study
