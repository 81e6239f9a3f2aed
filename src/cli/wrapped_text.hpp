// SPDX-License-Identifier: BSD-3-Clause
// Text in lines that fit on a screen.
#pragma once

#include <algorithm>
#include <cstddef>
#include <sstream>
#include <string>

namespace culm::cli {

/// Columns of printed text.
inline constexpr std::size_t text_width = 78;

/// Characters, not bytes: continuation bytes of UTF-8 take no room.
[[nodiscard]] inline std::size_t width_of(const std::string& text) {
    return static_cast<std::size_t>(std::ranges::count_if(
        text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

/// `first` and the text, in lines of at most `width` characters after an indent as wide as `first`.
[[nodiscard]] inline std::string wrapped(const std::string& first, const std::string& text,
                                         std::size_t width) {
    std::string out = first;
    std::istringstream words(text);
    std::size_t column = 0;
    for (std::string word; words >> word; column += width_of(word)) {
        if (column > 0 && column + 1 + width_of(word) > width) {
            out += '\n' + std::string(width_of(first), ' ');
            column = 0;
        } else if (column > 0) {
            out += ' ';
            ++column;
        }
        out += word;
    }
    return out + '\n';
}

} // namespace culm::cli
