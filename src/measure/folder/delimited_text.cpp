// SPDX-License-Identifier: BSD-3-Clause
#include "measure/folder/delimited_text.hpp"

#include "core/error.hpp"
#include "core/user_files.hpp"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>

namespace culm::measure {

namespace {

constexpr std::string_view blanks = " \t\r\n";

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
    return cell.empty() ? "is empty"
                        : "is not a number: write digits and one decimal point, without a unit, a "
                          "thousands separator, a date or a formula; leave the cell empty where "
                          "nothing was seen";
}

} // namespace culm::measure
