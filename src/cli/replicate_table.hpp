// SPDX-License-Identifier: BSD-3-Clause
// The spread of a study's stems as text.
#pragma once

#include "study/replicate_summary.hpp"

#include <string>

namespace culm::cli {

/// Spread of b1 and b2, stem to stem and within stems, and the factors that it comes from; empty
/// for a study without distributions, whose levels are no population.
[[nodiscard]] std::string replicate_table(const study::ReplicateSummary& summary);

} // namespace culm::cli
