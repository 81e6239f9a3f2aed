// SPDX-License-Identifier: BSD-3-Clause
// The columns of a foreign recording that a mapping asks for, in SI units.
#pragma once

#include "measure/import_mapping.hpp"

#include <string>
#include <vector>

namespace culm::measure {

struct RecordedSeries {
    std::vector<double> times;               ///< s, strictly ascending, in the source's time
    std::vector<std::string> names;          ///< columns or markers, each once
    std::vector<std::vector<double>> values; ///< (names, times), m; NaN for gaps
    std::optional<double> frames_per_second; ///< if the source says so

    [[nodiscard]] const std::vector<double>& of(const std::string& name) const;
};

/// Reads the named columns of a table: names are those of the header, or numbers from 1. Throws
/// core::InputError with file and line.
[[nodiscard]] RecordedSeries read_recorded_table(const ImportMapping& mapping);

/// Reads the named markers of a C3D file, projected on the mapping's axis; times count from the
/// first frame.
[[nodiscard]] RecordedSeries read_recorded_markers(const ImportMapping& mapping);

} // namespace culm::measure
