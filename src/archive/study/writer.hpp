// SPDX-License-Identifier: BSD-3-Clause
// Writing DIR/study.h5, the archive of a study, in one go.
#pragma once

#include "archive/point_record.hpp"
#include "archive/study/description.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace culm::archive {

/// Gives the record of a point, or nothing if it was not computed.
using RecordSource = std::function<std::optional<PointRecord>(std::int64_t point)>;
/// Numbers that the provenance gets after the last point, for example sums over all records.
using ClosingEntries = std::function<std::vector<std::pair<std::string, std::int64_t>>()>;

/// Writes the study file (docs/archive-format.md, version 1.0). `design` has the shape
/// (points, factors), row-major, in the units of the factor columns. Records are asked for once, in
/// order of their ids, and held one at a time. The same content gives the same bytes.
///
/// The file is written as "<path>.tmp", synchronised, and renamed: an older file at `path` stays
/// until the new one is whole, and on any error the temporary file is removed.
/// InputError: the description cannot be stored. StorageError: disk full, I/O error, or a record
/// whose arrays do not fit the description.
void write_study_file(const std::filesystem::path& path, const StudyDescription& description,
                      std::span<const double> design, const RecordSource& record_of_point,
                      const ClosingEntries& closing_entries = {});

} // namespace culm::archive
