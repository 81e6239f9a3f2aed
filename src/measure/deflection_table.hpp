// SPDX-License-Identifier: BSD-3-Clause
// deflection.csv: the deflection at each height and time.
#pragma once

#include "measure/measurement.hpp"

#include <filesystem>
#include <string>

namespace culm::measure {

/// Reads deflection.csv (format: docs/measurements.md) into times, heights and deflections of a
/// measurement whose stem is known; columns are sorted by height, and noise_by_height, which stands
/// in the order of the columns, with them. Throws core::InputError with every fault.
void read_deflection_file(const std::filesystem::path& file, Measurement& measurement);

/// The text of deflection.csv: mm and s, the shortest decimals that read back bit for bit.
[[nodiscard]] std::string deflection_file_text(const Measurement& measurement);

} // namespace culm::measure
