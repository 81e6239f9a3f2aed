// SPDX-License-Identifier: BSD-3-Clause
// Measured and modelled motion as a table: deflections.csv.
#pragma once

#include "fit/fit.hpp"
#include "measure/folder/measurement.hpp"

#include <string>
#include <utility>
#include <vector>

namespace culm::present {

/// A column of the time, s, and for every height the measured deflection and each model's under its
/// label, mm: one line for each frame that the first model's fit used. Empty cells: not seen.
[[nodiscard]] std::string
deflections_csv(const measure::Measurement& measurement,
                const std::vector<std::pair<std::string, const fit::RecordingFit*>>& models);

} // namespace culm::present
