// SPDX-License-Identifier: BSD-3-Clause
// Series of foreign recordings: columns of tables, and markers of C3D files, the exchange format of
// optical motion capture.
#pragma once

#include "measure/import/import_mapping.hpp"

#include <cstddef>
#include <filesystem>
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

/// The 3-D points of a C3D file, without analog channels, events and force plates.
struct C3dTracks {
    double frames_per_second = 0.0;
    std::string unit;                ///< of the coordinates as the file says, for example "mm"
    std::vector<std::string> labels; ///< (markers)
    std::size_t frames = 0;
    /// (frames, markers, 3) row-major, in `unit`; NaN where the marker was not seen.
    std::vector<double> positions;
};

/// Reads a C3D file ("The C3D File Format", Motion Lab Systems, 2008): Intel numbers,
/// points as floats or scaled integers, more than 65535 frames by POINT:LONG_FRAMES or
/// POINT:FRAMES. Debian 12 has no package of a maintained library, so the required parts are read
/// here. Throws core::InputError with the position of the fault in the file.
[[nodiscard]] C3dTracks read_c3d(const std::filesystem::path& file);

} // namespace culm::measure
