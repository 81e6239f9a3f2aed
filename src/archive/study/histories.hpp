// SPDX-License-Identifier: BSD-3-Clause
// The groups /histories and /particles: deflections over time and H5MD trajectories.
#pragma once

#include "archive/hdf5/write.hpp"
#include "archive/point_record.hpp"
#include "archive/study/description.hpp"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace culm::archive {

/// Name of a point's particle group, "point_000012".
[[nodiscard]] std::string particle_group_name(std::int64_t point);

/// Writes the points in order of their ids, with one history in memory at a time.
class HistoriesWriter {
  public:
    HistoriesWriter(const Hdf5Output& output, const StudyDescription& description);

    /// Appends the next point. nullptr: it has no histories (failed or missing), so it gets NaN in
    /// the tables and no particle group.
    void append(const PointRecord* record);

  private:
    void create_tables();
    void append_row(const DatasetHandle& dataset, hsize_t doubles_per_sample,
                    const std::vector<double>* row);
    void write_trajectory(const PointRecord& record);
    const Hdf5Output& output_;
    const StudyDescription& description_;
    hsize_t next_point_ = 0;
    std::vector<double> nothing_; ///< a row without a history
    GroupHandle histories_;
    GroupHandle particles_;
    DatasetHandle tip_;
    DatasetHandle heights_;
};

} // namespace culm::archive
