// SPDX-License-Identifier: BSD-3-Clause
#include "measure/folder/delimited_text.hpp"

#include "core/decimal_text.hpp"
#include "core/error.hpp"
#include "core/user_files.hpp"

#include <algorithm>
#include <array>
#include <cctype>

#include <fmt/format.h>

namespace culm::measure {

namespace {

constexpr std::string_view blanks = " \t\r\n";

bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

std::vector<std::string> split_line(std::string_view line, char delimiter) {
    std::vector<std::string> cells;
    std::string cell;
    bool is_quoted = false;
    bool had_quotes = false;
    const auto end_cell = [&] {
        cells.emplace_back(had_quotes ? cell : std::string(trimmed(cell)));
        cell.clear();
        had_quotes = false;
    };
    for (std::size_t i = 0; i < line.size(); ++i) {
        const char c = line[i];
        // RFC 4180: a quote opens a cell only at its start; a doubled quote inside is one.
        if (c == '"' && (is_quoted || trimmed(cell).empty())) {
            if (is_quoted && i + 1 < line.size() && line[i + 1] == '"')
                cell += line[++i];
            else if (is_quoted)
                is_quoted = false;
            else {
                is_quoted = had_quotes = true;
                cell.clear();
            }
        } else if (c == delimiter && !is_quoted) {
            end_cell();
        } else if (is_quoted || !had_quotes || blanks.find(c) == std::string_view::npos) {
            cell += c;
        }
    }
    end_cell();
    return cells;
}

bool has_content(const DelimitedLine& line) {
    return std::ranges::any_of(line.cells, [](const std::string& cell) { return !cell.empty(); });
}

bool has_letters(std::string_view text) {
    return std::ranges::any_of(
        text, [](char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; });
}

/// "14.01.2024", "2024-01-14", "1/2/24", "12:30", "14-Jan", "Jan 14".
bool looks_like_date(std::string_view cell) {
    constexpr std::array<std::string_view, 12> months{"jan", "feb", "mar", "apr", "may", "jun",
                                                      "jul", "aug", "sep", "oct", "nov", "dec"};
    const std::string lower = lower_case(cell);
    const bool has_digit = std::ranges::any_of(lower, is_digit);
    for (const std::string_view month : months)
        if (has_digit && lower.find(month) != std::string::npos)
            return true;
    if (has_letters(lower))
        return false;
    const auto count_of = [&](char c) { return std::ranges::count(lower, c); };
    return count_of('.') >= 2 || count_of(':') >= 1 || count_of('/') >= 1 ||
           (count_of('-') >= 2 && lower.front() != '-');
}

/// The length of the number at the beginning of a cell.
std::size_t length_of_number(std::string_view cell) {
    // The longest prefix first: "1e3 mm" begins with the number 1e3 and not with 1.
    for (std::size_t length = cell.size(); length > 0; --length)
        if (core::parse_decimal(trimmed(cell.substr(0, length))))
            return length;
    return 0;
}

} // namespace

std::string_view trimmed(std::string_view text) {
    const std::size_t first = text.find_first_not_of(blanks);
    if (first == std::string_view::npos)
        return {};
    return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

std::string lower_case(std::string_view text) {
    std::string result(text);
    std::ranges::transform(result, result.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return result;
}

std::string read_text_file(const std::filesystem::path& file) {
    std::string text = core::file_text(file, core::largest_recording);
    if (text.starts_with("\xEF\xBB\xBF"))
        text.erase(0, 3);
    if (trimmed(text).empty())
        throw core::InputError(fmt::format("{}: the file is empty", file.string()));
    if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF"))
        throw core::InputError(fmt::format(
            "{}:1: the text is UTF-16 (\"Unicode text\" of a spreadsheet): save it as CSV UTF-8",
            file.string()));
    if (text.starts_with("PK\x03\x04"))
        throw core::InputError(
            fmt::format("{}: this is a workbook or an archive, not text: save the sheet as CSV",
                        file.string()));
    if (text.find('\0') != std::string::npos)
        throw core::InputError(fmt::format("{}: this is not a text file", file.string()));
    return text;
}

std::vector<DelimitedLine> split_table(std::string_view text, char delimiter) {
    std::vector<DelimitedLine> lines;
    std::size_t number = 0;
    while (!text.empty()) {
        ++number;
        const std::size_t end = text.find_first_of("\r\n");
        const std::string_view line = text.substr(0, end);
        std::size_t next = end == std::string_view::npos ? text.size() : end + 1;
        // A single carriage return also ends a line, because some instruments write it.
        if (end != std::string_view::npos && text.substr(end, 2) == "\r\n")
            ++next;
        text.remove_prefix(next);
        const bool is_comment = lines.empty() && trimmed(line).starts_with('#');
        if (!trimmed(line).empty() && !is_comment)
            lines.push_back({number, split_line(line, delimiter)});
    }
    while (!lines.empty() && !has_content(lines.back()))
        lines.pop_back();
    return lines;
}

std::string why_not_a_number(std::string_view cell) {
    if (cell.empty())
        return "is empty";
    if (cell.front() == '#')
        return "is an error value of a spreadsheet; leave the cell empty where nothing was seen";
    if (cell.front() == '=')
        return "is a formula; save the values of the sheet, not its formulas";
    if (cell.find("\xE2\x88\x92") != std::string_view::npos ||
        cell.find("\xE2\x80\x93") != std::string_view::npos)
        return "has a typographic minus sign or a dash; write -";
    const bool has_comma = cell.find(',') != std::string_view::npos;
    const bool has_point = cell.find('.') != std::string_view::npos;
    if (has_comma && !has_letters(cell))
        return has_point ? "has a thousands separator; write digits and one decimal point"
                         : "has a decimal comma; write a decimal point";
    if (looks_like_date(cell))
        return "is a date or a time of day: a spreadsheet has turned the number into one; format "
               "the column as a number";
    if (cell.find('\'') != std::string_view::npos ||
        cell.find("\xC2\xA0") != std::string_view::npos)
        return "has a thousands separator or an apostrophe; write digits and one decimal point";
    const std::size_t number = length_of_number(cell);
    if (number > 0 && has_letters(cell.substr(number)))
        return "carries a unit or a note; units belong into the header";
    if (number > 0)
        return "holds more than a number; write digits and one decimal point";
    return "is not a number; leave the cell empty where nothing was seen";
}

} // namespace culm::measure
