// SPDX-License-Identifier: BSD-3-Clause
// A table of the study file: one dataset per column, written row by row.
#pragma once

#include "archive/hdf5_write.hpp"
#include "archive/study_description.hpp"

#include <span>
#include <vector>

namespace culm::archive {

/// Writes the columns of one group; holds one chunk of rows in memory.
class TableWriter {
  public:
    /// Creates the datasets, and the attribute `columns` that lists their names in order.
    TableWriter(const Hdf5Output& output, const GroupHandle& group, std::span<const Column> columns,
                hsize_t rows);

    /// One value per column.
    void append(std::span<const double> row);

  private:
    void flush();

    const Hdf5Output& output_;
    hsize_t rows_;
    hsize_t chunk_rows_;
    hsize_t written_ = 0;
    hsize_t buffered_ = 0;
    std::vector<DatasetHandle> datasets_;
    std::vector<std::vector<double>> buffers_; ///< (columns, rows of a chunk)
};

} // namespace culm::archive
