// SPDX-License-Identifier: BSD-3-Clause
// The description of a study in its file: everything except the points.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace culm::archive {

/// Name and version of the study file's format (docs/archive-format.md).
inline constexpr std::string_view study_format_name = "culm-study";
/// A reader refuses another major version; a minor version only adds.
inline constexpr int study_format_major = 1;
inline constexpr int study_format_minor = 1;

/// Names and texts, in the order given.
using Texts = std::vector<std::pair<std::string, std::string>>;

/// The text of that name; empty if there is none.
[[nodiscard]] inline std::string text_named(std::string_view name, const Texts& texts) {
    const auto found = std::ranges::find(texts, name, &Texts::value_type::first);
    return found == texts.end() ? std::string() : found->second;
}

/// Name of a point's particle group, "point_000012".
[[nodiscard]] inline std::string particle_group_name(std::int64_t point) {
    return fmt::format("point_{:06}", point);
}

/// One column of a table.
struct Column {
    std::string name; ///< of the dataset: not empty, no '/', unique in its table
    std::string unit; ///< "1" if dimensionless
    std::string description;

    bool operator==(const Column&) const = default;
};

/// Which histories are stored for every completed point.
struct StoredHistories {
    bool tip = false;
    bool heights = false;
    bool positions = false;

    bool operator==(const StoredHistories&) const = default;
};

struct StudyDescription {
    std::int64_t points = 0;     ///< in the design; their ids are 0 … points − 1
    std::vector<Column> factors; ///< columns of the design
    std::vector<Column> results; ///< columns of PointRecord::values
    StoredHistories stored;
    std::vector<double> times;   ///< of the samples, s; needed if any history is stored
    std::vector<double> heights; ///< above the clamp, m; needed for height histories
    int spheres = 0;             ///< in the chain; needed for positions
    std::string identity;        ///< canonical configuration; decides what may be resumed
    std::string version;         ///< of culm
    /// Name and text, in the order given: compiler, libraries, hosts, ranks, seed, start, end …
    /// "identity" and "entries" are reserved; "config" and texts above 8 KiB become datasets.
    Texts provenance;
    int trajectory_compression = 0; ///< deflate level 0 … 9 for positions in the study file
    bool single_precision = false;  ///< positions are stored as float32

    bool operator==(const StudyDescription&) const = default;
};

} // namespace culm::archive
