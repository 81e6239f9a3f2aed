// SPDX-License-Identifier: BSD-3-Clause
// The mapping file of `culm import`, which makes a measurement of a foreign table or recording.
#pragma once

#include "measure/folder/measurement.hpp"

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace culm::measure {

/// Which deflection counts as zero.
enum class ZeroDeflection {
    BeforeRelease, ///< the mean of the frames before the release: held straight
    AtRest,        ///< the mean of the last tenth of the record: pulled aside
    AsGiven        ///< the source's deflections count from the undeformed axis
};

/// Unit of the time column.
enum class TimeUnit { Second, Millisecond, Microsecond, Frame };

/// One height of the result and the columns or markers of the source whose mean it is.
struct MappedHeight {
    double height = 0.0; ///< m
    std::vector<std::string> names;
};

struct ImportMapping {
    std::filesystem::path source; ///< the recording
    /// The source has the columns "t" (s) and "NAME x", "NAME y", "NAME z" (m) of markers.
    bool has_markers = false;
    std::optional<char> delimiter; ///< of a table; empty: guessed
    bool has_decimal_comma = false;
    std::size_t skipped_lines = 0; ///< ahead of a table's header

    std::string time_column; ///< of a table
    TimeUnit time_unit = TimeUnit::Second;
    std::optional<double> release; ///< s in the source's time; empty: detected, if it was recorded
    std::optional<double> before;  ///< s kept before the release; empty: all
    std::optional<double> after;   ///< s kept after it

    int power_of_ten = -3;        ///< of the unit of length
    double scale = 1.0;           ///< mm per pixel, of a table in pixels
    std::array<double, 3> axis{}; ///< unit vector of positive deflection, for markers
    double sign = 1.0;            ///< −1 reverses a table's deflections
    ZeroDeflection zero = ZeroDeflection::AsGiven;
    std::vector<std::string> clamp; ///< columns or markers whose motion is subtracted
    std::vector<MappedHeight> heights;
    Measurement measurement; ///< the mapping's data on stem, sensors, camera and measurement
};

/// Formats that the program postprocess/recording_table.py turns into tables.
[[nodiscard]] bool needs_conversion(const std::filesystem::path& recording);

/// Reads a mapping (format: docs/measurements.md); the source's path is relative to the mapping's
/// folder. `source`, if not empty, replaces the source named in the mapping. Throws
/// core::InputError with every fault.
[[nodiscard]] ImportMapping read_import_mapping(const std::filesystem::path& file,
                                                const std::filesystem::path& source = {});

} // namespace culm::measure
