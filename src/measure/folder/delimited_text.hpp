// SPDX-License-Identifier: BSD-3-Clause
// Text tables as written by programs and spreadsheets: lines, cells, and faults of a cell.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace culm::measure {

struct DelimitedLine {
    std::size_t number = 0; ///< in the file, from 1
    std::vector<std::string> cells;
};

/// Without blanks and ends of lines on both sides.
[[nodiscard]] std::string_view trimmed(std::string_view text);
[[nodiscard]] std::string lower_case(std::string_view text);

/// The text of a file, without a UTF-8 byte order mark. Throws core::InputError if the file cannot
/// be read, is empty, is UTF-16, or is not text (a workbook, for example).
[[nodiscard]] std::string read_text_file(const std::filesystem::path& file);

/// Lines (ending with LF, CRLF or CR) split at the delimiter, cells without surrounding spaces and
/// quotes; a quoted cell may contain the delimiter. Blank lines, lines that begin with # before the
/// first table line, and empty lines at the end are skipped.
[[nodiscard]] std::vector<DelimitedLine> split_table(std::string_view text, char delimiter);

/// Why a cell is not a number, and what to write.
[[nodiscard]] std::string why_not_a_number(std::string_view cell);

} // namespace culm::measure
