// SPDX-License-Identifier: BSD-3-Clause
// Texts, shares, durations and sizes in readable form.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <sstream>
#include <string>

#include <fmt/core.h>

namespace culm::present {

/// Columns of printed text.
inline constexpr std::size_t text_width = 78;
/// Columns of the running text between tables of results, which need up to 100.
inline constexpr std::size_t result_width = 98;

/// Number of characters, not bytes: continuation bytes of UTF-8 are not counted.
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

/// `sentence` in lines of result_width, indented by `indent`.
[[nodiscard]] inline std::string result_lines(const std::string& indent,
                                              const std::string& sentence) {
    return wrapped(indent, sentence, result_width - indent.size());
}

/// "1 height", "9 heights".
[[nodiscard]] inline std::string counted(std::integral auto count, const char* noun) {
    return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

/// A cell of a table; "-" if there is no number.
[[nodiscard]] inline std::string number_cell(double value, int decimals) {
    return std::isfinite(value) ? fmt::format("{:.{}f}", value, decimals) : std::string("-");
}

/// "+74 %", "-0.71 %"; "0 %" below a hundredth of a percent; "-" for NaN.
[[nodiscard]] inline std::string percent_text(double share) {
    const double percent = 100.0 * share;
    if (std::isnan(percent))
        return "-";
    if (std::abs(percent) < 0.01)
        return "0 %";
    return std::abs(percent) < 10.0 ? fmt::format("{:+.2g} %", percent)
                                    : fmt::format("{:+.0f} %", percent);
}

/// An estimated duration, to two digits: "0.4 s", "40 s", "3 min", "1.5 h".
[[nodiscard]] inline std::string estimate_text(double seconds) {
    return seconds < 90.0     ? fmt::format("{:.2g} s", seconds)
           : seconds < 5400.0 ? fmt::format("{:.2g} min", seconds / 60.0)
                              : fmt::format("{:.2g} h", seconds / 3600.0);
}

/// "812 B", "12 kB", "3.4 MB", "1.2 GB".
[[nodiscard]] inline std::string bytes_text(double bytes) {
    return bytes < 1e3   ? fmt::format("{:.0f} B", bytes)
           : bytes < 1e6 ? fmt::format("{:.3g} kB", bytes * 1e-3)
           : bytes < 1e9 ? fmt::format("{:.3g} MB", bytes * 1e-6)
                         : fmt::format("{:.3g} GB", bytes * 1e-9);
}

/// A warning if the residual over the noise is so large that a fit's numbers mean little, or empty.
[[nodiscard]] inline std::string far_off_sentence(double over_noise) {
    constexpr double far_off = 20.0;
    return over_noise > far_off
               ? fmt::format("The model does not describe the readings: its residual is {:.0f} "
                             "times the noise.",
                             over_noise)
               : std::string();
}

} // namespace culm::present
