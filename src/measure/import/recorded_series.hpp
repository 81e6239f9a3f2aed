// SPDX-License-Identifier: BSD-3-Clause
// Series of foreign recordings: columns of tables, and positions of markers along an axis.
#pragma once

#include "measure/import/import_mapping.hpp"

#include <string>
#include <vector>

namespace culm::measure {

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

} // namespace culm::measure
