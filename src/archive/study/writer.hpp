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

/// Returns the record of a point; nothing if it was not computed.
using RecordSource = std::function<std::optional<PointRecord>(std::int64_t point)>;
/// Numbers to be added to the provenance after the last point, for example sums over all records.
using ClosingEntries = std::function<std::vector<std::pair<std::string, std::int64_t>>()>;

/// Writes the study file (docs/archive-format.md, version 1.0). `design` has the shape
/// (points, factors), row-major, in the units of the factor columns. Each record is requested
/// once, in order of the ids, and freed before the next one. Equal content gives equal bytes.
///
/// The file is written as "<path>.tmp", synchronised, and renamed: an older file at `path` is kept
/// until the new one is complete, and on any error the temporary file is removed.
/// Throws StorageError: disk full, I/O error, or a record whose arrays do not fit the description.
void write_study_file(const std::filesystem::path& path, const StudyDescription& description,
                      std::span<const double> design, const RecordSource& record_of_point,
                      const ClosingEntries& closing_entries = {});

} // namespace culm::archive
