// SPDX-License-Identifier: BSD-3-Clause
// Converts a foreign table or recording to a measurement, as the mapping file of `culm import`
// says.
#pragma once

#include "measure/folder/measurement.hpp"

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
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

/// Series of a recording: columns of a table, or positions of markers along an axis.
struct RecordedSeries {
    std::vector<double> times;               ///< s, strictly ascending, in the source's time
    std::vector<std::string> names;          ///< columns or markers, each once
    std::vector<std::vector<double>> values; ///< (names, times), SI; NaN for gaps

    [[nodiscard]] const std::vector<double>& of(const std::string& name) const;
};

/// Reads the named columns of a table (names are those of the header, or numbers from 1), or the
/// positions of the named markers along the mapping's axis. Throws core::InputError with file and
/// line.
[[nodiscard]] RecordedSeries read_recorded_table(const ImportMapping& mapping);

/// Reads the mapping's source and returns a measurement: the mean over the columns or markers of
/// each height, less the motion of the clamp's, relative to the zero that the mapping chooses, with
/// t = 0 at the release; see release_onset() for its detection. If the mapping states no noise, it
/// is the scatter before the release (at least 8 frames), reported in noise_source. Frames in which
/// the stem moves are not used for the noise; a remark reports them. Throws core::InputError.
[[nodiscard]] Measurement import_recording(const ImportMapping& mapping);

struct ReleaseOnset {
    double time = 0.0;        ///< s
    double uncertainty = 0.0; ///< standard uncertainty, s
};
/// The release in a history of positions: where the first fast motion leaves the line on which a
/// hand that moves slowly had led the stem. Between two frames it is interpolated by the root of
/// the travel. Empty if fewer than five frames lie before the motion, or if it starts at once. Gaps
/// are NaN.
[[nodiscard]] std::optional<ReleaseOnset> release_onset(std::span<const double> times,
                                                        std::span<const double> positions);

/// Gaps between consecutive frames that are longer than one and a half usual frame times.
struct TimeGaps {
    std::size_t count = 0;
    double longest = 0.0;          ///< s, from frame to frame
    double begin_of_longest = 0.0; ///< s
};
[[nodiscard]] TimeGaps time_gaps(std::span<const double> times);

} // namespace culm::measure
