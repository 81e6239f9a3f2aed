// SPDX-License-Identifier: BSD-3-Clause
// A column of a table of measured stems.
#pragma once

#include "study/parameter_table.hpp"
#include "study/units.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace culm::study {

struct ColumnRequest {
    std::string_view file; ///< for messages
    std::string_view column;
    std::string_view unit; ///< "" takes that of the column's name, else that of the parameter
    bool keeps_rows = false;
};

/// The values in SI, row by row, of the column with that header; the text is a table with a header
/// (comma, semicolon or tab). Empty cells are left out, or refused where rows are kept. Throws
/// core::InputError with the file, the line and what is wrong: no such column (with the nearest
/// name), no number, a unit of another kind, a value that the parameter does not allow, no values.
[[nodiscard]] std::vector<double>
measured_values(std::string_view text, const ColumnRequest& request, const Parameter& parameter);

} // namespace culm::study
