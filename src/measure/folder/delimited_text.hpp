// SPDX-License-Identifier: BSD-3-Clause
// Text tables as programs and spreadsheets write them: lines, cells, and what went wrong in a cell.
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

/// The text of a file, without a UTF-8 byte order mark. Throws core::InputError if it cannot be
/// read, is empty, is UTF-16, or is no text (a workbook, for example).
[[nodiscard]] std::string read_text_file(const std::filesystem::path& file);

/// Lines (ending with LF, CRLF or CR) split at the delimiter, cells without surrounding spaces and
/// quotes; a quoted cell may hold the delimiter. Left out: blank lines, lines that begin with #
/// ahead of the first table line, and lines without any content at the end.
[[nodiscard]] std::vector<DelimitedLine> split_table(std::string_view text, char delimiter);

/// Why a cell is not a number, with what to do: decimal commas, dates, error values and units of
/// spreadsheets, typographic minus signs, thousands separators; "is not a number" for anything
/// else.
[[nodiscard]] std::string why_not_a_number(std::string_view cell);

} // namespace culm::measure
