// SPDX-License-Identifier: BSD-3-Clause
// The two files of a measurement folder: stem.toml (the stem) and deflection.csv.
#pragma once

#include "core/interval.hpp"
#include "core/toml/table.hpp"
#include "measure/folder/measurement.hpp"

#include <filesystem>
#include <string>

namespace culm::measure {

/// Limits of laboratory dimensions; a length in a wrong unit is outside or near the ends.
struct StemLimits {
    static constexpr core::Interval length{1e-3, 100.0}; ///< m
    static constexpr core::Interval width{1e-5, 10.0};   ///< of a section, m
    static constexpr core::Interval density{1e-3, 1e5};  ///< kg/m³
    static constexpr core::Interval frame_time_ms{0.0, 1e3};
};

/// Reads the tables [stem], [section], [[added_mass]], [release], [camera] and [measurement] of a
/// file into the measurement. Faults are added to the document, remarks for the user to the
/// measurement.
void read_stem_tables(const core::TomlTable& root, Measurement& measurement);

/// Adds a fault if the height in the table, m, lies above the stem.
void check_is_on_stem(const core::TomlTable& table, double height, const MeasuredStem& stem);

/// Reads stem.toml (format: docs/measurements.md): all fields of the measurement except times,
/// heights and deflections. Throws core::InputError with every fault.
[[nodiscard]] Measurement read_stem_file(const std::filesystem::path& file);

/// The text of stem.toml; reading it gives the same numbers bit for bit, a mass that another key
/// than the density gave to twelve digits.
[[nodiscard]] std::string stem_file_text(const Measurement& measurement);

/// Reads deflection.csv (format: docs/measurements.md) into times, heights and deflections of a
/// measurement whose stem is known. Columns are sorted by height; noise_by_height, which is in the
/// order of the columns, is sorted with them. Throws core::InputError with every fault.
void read_deflection_file(const std::filesystem::path& file, Measurement& measurement);

/// The text of deflection.csv: mm and s, the shortest decimals that read back bit for bit.
[[nodiscard]] std::string deflection_file_text(const Measurement& measurement);

} // namespace culm::measure
