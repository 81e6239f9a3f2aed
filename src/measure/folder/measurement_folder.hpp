// SPDX-License-Identifier: BSD-3-Clause
// The measurement folder: stem.toml and deflection.csv, and uncertainty.csv if each reading has its
// own uncertainty.
#pragma once

#include "measure/folder/measurement.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace culm::measure {

inline constexpr const char* stem_file_name = "stem.toml";
inline constexpr const char* deflection_file_name = "deflection.csv";
inline constexpr const char* uncertainty_file_name = "uncertainty.csv";

/// Reads FOLDER/stem.toml, FOLDER/deflection.csv and, if it exists, FOLDER/uncertainty.csv, which
/// has the same times and heights (format: docs/measurements.md). Throws core::InputError with
/// every fault found: file, line, value, the allowed values, and the probable action of a
/// spreadsheet.
[[nodiscard]] Measurement read_measurement(const std::filesystem::path& folder);

/// Writes the files of a measurement without sensors and creates the folder; reading them gives the
/// same numbers bit for bit. Throws core::InputError if the reader refuses the files, which remain,
/// core::StorageError if a file cannot be written.
void write_measurement(const std::filesystem::path& folder, const Measurement& measurement);

/// The measurement folders that a path names: the path itself if it contains deflection.csv, else
/// the folders directly inside it that do, by name. Throws core::InputError if there are none.
[[nodiscard]] std::vector<std::filesystem::path>
find_measurements(const std::filesystem::path& path);

/// Measurements and the folders that they were read from.
struct MeasurementSet {
    std::vector<Measurement> measurements;
    std::vector<std::filesystem::path> folders;
};

/// All measurements that the paths name, as find_measurements() finds them. Throws core::InputError
/// with the faults of all of them together.
[[nodiscard]] MeasurementSet read_measurements(const std::vector<std::string>& paths);

} // namespace culm::measure
