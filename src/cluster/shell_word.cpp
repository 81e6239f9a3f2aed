// SPDX-License-Identifier: BSD-3-Clause
#include "cluster/shell_word.hpp"

#include <algorithm>
#include <cctype>

namespace culm::cluster {

std::string shell_word(std::string_view text) {
    const auto is_plain = [](unsigned char c) {
        return std::isalnum(c) != 0 ||
               std::string_view("/._-+=:,@%").find(char(c)) != std::string_view::npos;
    };
    if (!text.empty() && std::ranges::all_of(text, is_plain))
        return std::string(text);
    std::string word = "'";
    for (const char c : text)
        word += c == '\'' ? std::string("'\\''") : std::string(1, c); // no quote within quotes
    return word + "'";
}

} // namespace culm::cluster
