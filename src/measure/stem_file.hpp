// SPDX-License-Identifier: BSD-3-Clause
// stem.toml: what is known of a measured stem.
#pragma once

#include "core/toml/table.hpp"
#include "measure/measurement.hpp"

#include <filesystem>
#include <string>

namespace culm::measure {

/// Reads the tables [stem], [section], [[added_mass]], [release], [camera] and [measurement] of a
/// file into the measurement; faults go into the document, and what a person should know into the
/// measurement's remarks.
void read_stem_tables(const core::TomlTable& root, Measurement& measurement);

/// Reads stem.toml (format: docs/measurements.md): all fields of the measurement but times, heights
/// and deflections. Throws core::InputError with every fault.
[[nodiscard]] Measurement read_stem_file(const std::filesystem::path& file);

/// The text of stem.toml; reading it gives the same numbers bit for bit.
[[nodiscard]] std::string stem_file_text(const Measurement& measurement);

} // namespace culm::measure
