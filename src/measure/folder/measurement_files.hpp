// SPDX-License-Identifier: BSD-3-Clause
// The two files of a measurement folder: stem.toml (the stem) and deflection.csv.
#pragma once

#include "core/toml/table.hpp"
#include "measure/folder/measurement.hpp"

#include <filesystem>
#include <string>

namespace culm::measure {

/// Reads the tables [stem], [section], [[added_mass]], [release], [camera] and [measurement] of a
/// file into the measurement. Faults are added to the document, remarks for the user to the
/// measurement.
void read_stem_tables(const core::TomlTable& root, Measurement& measurement);

/// Reads stem.toml (format: docs/measurements.md): all fields of the measurement except times,
/// heights and deflections. Throws core::InputError with every fault.
[[nodiscard]] Measurement read_stem_file(const std::filesystem::path& file);

/// The text of stem.toml; reading it gives the same numbers bit for bit.
[[nodiscard]] std::string stem_file_text(const Measurement& measurement);

/// Reads deflection.csv (format: docs/measurements.md) into times, heights and deflections of a
/// measurement whose stem is known. Columns are sorted by height; noise_by_height, which is in the
/// order of the columns, is sorted with them. Throws core::InputError with every fault.
void read_deflection_file(const std::filesystem::path& file, Measurement& measurement);

/// The text of deflection.csv: mm and s, the shortest decimals that read back bit for bit.
[[nodiscard]] std::string deflection_file_text(const Measurement& measurement);

} // namespace culm::measure
