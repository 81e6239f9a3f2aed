// SPDX-License-Identifier: BSD-3-Clause
// stem.toml: what is known of a measured stem.
#pragma once

#include "measure/measurement.hpp"
#include "measure/toml_table.hpp"

#include <filesystem>
#include <string>

namespace culm::measure {

/// Reads the tables [stem], [section], [[added_mass]], [release], [camera] and [measurement] of a
/// root table into the measurement; faults and remarks are recorded, unknown tables of the root are
/// left to the caller's finish().
void read_stem_tables(TomlTable& root, Measurement& measurement);

/// Reads stem.toml (format: docs/measurements.md): all fields of the measurement but times, heights
/// and deflections. Throws core::InputError with every fault.
[[nodiscard]] Measurement read_stem_file(const std::filesystem::path& file);

/// The text of stem.toml; reading it gives the same numbers bit for bit.
[[nodiscard]] std::string stem_file_text(const Measurement& measurement);

} // namespace culm::measure
