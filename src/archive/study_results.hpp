// SPDX-License-Identifier: BSD-3-Clause
// The group /results: status, reason of failure, and one column per fitted number.
#pragma once

#include "archive/hdf5_write.hpp"
#include "archive/point_record.hpp"
#include "archive/study_description.hpp"
#include "archive/study_table.hpp"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace culm::archive {

/// Longest failure text that is stored, in bytes; a longer one ends with "…".
inline constexpr std::size_t longest_failure_text = 1024;

/// Takes the points in order of their ids. Keeps states and reasons of failure in memory.
class ResultsWriter {
  public:
    ResultsWriter(const Hdf5Output& output, const StudyDescription& description);

    /// The next point; nullptr if it is missing.
    void append(const PointRecord* record);
    /// After the last point.
    void finish();

  private:
    using Texts = std::map<std::size_t, std::string>; ///< by row; the other rows are empty

    void write_texts(const std::string& name, const Texts& texts, const std::string& description);

    const Hdf5Output& output_;
    GroupHandle group_;
    TableWriter table_;
    std::vector<double> no_values_; ///< a row of NaN
    std::vector<std::uint8_t> statuses_;
    Texts failure_kinds_;
    Texts failure_reasons_;
};

} // namespace culm::archive
