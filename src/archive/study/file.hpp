// SPDX-License-Identifier: BSD-3-Clause
// Reading DIR/study.h5, the archive of a study, and checking whether every byte of its data is
// unchanged.
#pragma once

#include "archive/point_record.hpp"
#include "archive/study/description.hpp"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace culm::archive {

class Hdf5Input;
class TrajectoryFolder;

/// An open study file; one dataset or one point is read at a time. Damaged data never give wrong
/// numbers, but a StorageError that names the dataset.
class StudyFile {
  public:
    /// A child process opens the file first: HDF5 may crash on a damaged one. Not for processes
    /// with several threads. StorageError: not an HDF5 file, truncated, damaged, or locked.
    /// InputError: not a culm study, or its major format version is unknown.
    explicit StudyFile(const std::filesystem::path& path);

    [[nodiscard]] const std::filesystem::path& path() const;
    /// The description that was given to write_study_file.
    [[nodiscard]] const StudyDescription& description() const { return description_; }
    [[nodiscard]] std::int64_t point_count() const { return description_.points; }
    /// (points)
    [[nodiscard]] const std::vector<PointStatus>& statuses() const { return statuses_; }
    [[nodiscard]] PointStatus status(std::int64_t point) const;

    /// One column (points), in its unit. InputError if there is no such column; the message names
    /// the nearest one.
    [[nodiscard]] std::vector<double> factor(const std::string& name) const {
        return column("/design", description_.factors, name);
    }
    /// As factor; NaN where the point failed or is missing.
    [[nodiscard]] std::vector<double> result(const std::string& name) const {
        return column("/results", description_.results, name);
    }
    /// Histories of a completed point. InputError if the study does not store them, or if the point
    /// is outside of the design, failed, or missing.
    [[nodiscard]] std::vector<double> tip_deflection(std::int64_t point) const; ///< (samples), m
    /// (samples, heights) row-major, m
    [[nodiscard]] std::vector<double> height_deflection(std::int64_t point) const;
    /// (samples, spheres, 3) row-major, m
    [[nodiscard]] std::vector<double> positions(std::int64_t point) const;
    /// Where the trajectory of a completed point is stored; nothing if it is in this file.
    [[nodiscard]] std::optional<TrajectoryPlace> trajectory(std::int64_t point) const;

    /// Why a failed point has no answer; both empty for others.
    [[nodiscard]] std::string failure_kind(std::int64_t point) const {
        return text_of_failure("/results/failure_kind", point);
    }
    [[nodiscard]] std::string failure_reason(std::int64_t point) const {
        return text_of_failure("/results/failure_reason", point);
    }

    /// All stored data of a point, with the place of a trajectory that another file holds; nothing
    /// if it is missing. Reading neighbouring points in order is fast, because results are read a
    /// chunk at a time.
    [[nodiscard]] std::optional<PointRecord> record(std::int64_t point) const;

  private:
    void open(const std::filesystem::path& path);
    void require_point(std::int64_t point) const;
    /// The values, or StorageError if there are more or fewer.
    [[nodiscard]] std::vector<double>
    require_size(const std::string& dataset, std::vector<double> values, std::size_t size) const;
    /// The `size` numbers of a completed point's history: its row of a table in /histories, or a
    /// dataset of its own. `what` names the history in messages.
    [[nodiscard]] std::vector<double> history(bool stored, const char* what, std::int64_t point,
                                              const std::string& dataset, std::size_t size) const;
    [[nodiscard]] std::string text_of_failure(const std::string& dataset, std::int64_t point) const;
    /// All results of a point.
    [[nodiscard]] std::vector<double> result_values(std::int64_t point) const;
    [[nodiscard]] std::vector<double> column(const std::string& table,
                                             const std::vector<Column>& columns,
                                             const std::string& name) const;

    // Behind pointers: callers do not see hdf5.h.
    std::shared_ptr<const Hdf5Input> input_;
    std::shared_ptr<TrajectoryFolder> trajectories_;
    StudyDescription description_;
    std::vector<PointStatus> statuses_;
    mutable std::optional<std::vector<double>> places_;    ///< (points, 4) if they were asked for
    mutable std::vector<std::vector<double>> result_rows_; ///< (columns, rows of one chunk)
    mutable std::int64_t first_result_row_ = -1;           ///< of these; -1: none are stored
};

struct DamagedDataset {
    std::string name;                ///< absolute path in the file
    std::int64_t damaged_chunks = 0; ///< absent ones included
    std::int64_t chunks = 0;         ///< required by the dataset's shape
    std::string reason;              ///< of the first damage
};

struct Verification {
    std::int64_t datasets = 0;
    std::int64_t chunks = 0;
    std::vector<DamagedDataset> damaged; ///< in order of their names

    [[nodiscard]] bool is_whole() const { return damaged.empty(); }
};

/// Reads every chunk of every dataset, which makes HDF5 check its checksum, and the checksums of
/// the texts. StorageError or InputError if the file cannot be opened as a culm study at all.
[[nodiscard]] Verification verify(const std::filesystem::path& path);

} // namespace culm::archive
