// SPDX-License-Identifier: BSD-3-Clause
// Text for man(1): escapes and faces.
#pragma once

#include <string>
#include <string_view>

namespace culm::cli {

/// Text that roff would otherwise take for a request or an escape.
[[nodiscard]] inline std::string roff_text(std::string_view text) {
    std::string out;
    for (const char c : text) {
        if (out.empty() && (c == '.' || c == '\''))
            out += "\\&";
        if (c == '\\')
            out += "\\e";
        else if (c == '-')
            out += "\\-";
        else
            out += c;
    }
    return out;
}

[[nodiscard]] inline std::string roff_bold(std::string_view text) {
    return "\\fB" + roff_text(text) + "\\fR";
}

[[nodiscard]] inline std::string roff_italic(std::string_view text) {
    return "\\fI" + roff_text(text) + "\\fR";
}

} // namespace culm::cli
