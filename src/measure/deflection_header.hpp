// SPDX-License-Identifier: BSD-3-Clause
// The header of deflection.csv: which column is which height, and in which unit.
#pragma once

#include "core/file_faults.hpp"
#include "measure/delimited_text.hpp"
#include "measure/measurement.hpp"

#include <string>
#include <vector>

namespace culm::measure {

struct DeflectionHeader {
    std::vector<double> heights; ///< m, in the order of the columns
    int power_of_ten = -3;       ///< of the unit of heights and deflections: mm −3, m 0
    std::size_t unnamed = 0;     ///< columns without a name at the end
};

/// Reads "time_s,h=<height><unit>,…", unit mm or m, the same in all columns, which is the unit of
/// the deflections as well. Records what is wrong; the result is only complete if nothing was.
[[nodiscard]] DeflectionHeader read_deflection_header(const DelimitedLine& line,
                                                      const MeasuredStem& stem,
                                                      core::FileFaults& faults);

} // namespace culm::measure
