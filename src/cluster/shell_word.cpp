// SPDX-License-Identifier: BSD-3-Clause
#include "cluster/shell_word.hpp"

#include "core/error.hpp"

#include <algorithm>

#include <fmt/core.h>

namespace culm::cluster {

namespace {

bool is_plain(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("/._-+=:,@%").find(c) != std::string_view::npos;
}

bool is_control(char c) {
    return static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
}

/// $'...': the form of bash in which quotes and control characters can be written.
std::string escaped_word(std::string_view text) {
    std::string word = "$'";
    for (const char c : text) {
        if (is_control(c))
            word += fmt::format("\\{:03o}", static_cast<unsigned>(static_cast<unsigned char>(c)));
        else if (c == '\'' || c == '\\')
            (word += '\\') += c;
        else
            word += c;
    }
    return word + "'";
}

} // namespace

std::string shell_word(std::string_view text) {
    if (text.find('\0') != std::string_view::npos)
        throw core::InputError("a text with a zero byte cannot be written to a script");
    // Single quotes cannot contain a quote.
    if (std::ranges::any_of(text, [](char c) { return c == '\'' || is_control(c); }))
        return escaped_word(text);
    if (!text.empty() && std::ranges::all_of(text, is_plain))
        return std::string(text);
    return fmt::format("'{}'", text);
}

} // namespace culm::cluster
