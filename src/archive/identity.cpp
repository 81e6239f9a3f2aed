// SPDX-License-Identifier: BSD-3-Clause
#include "archive/identity.hpp"

#include "core/error.hpp"

#include <fmt/format.h>

namespace culm::archive {

namespace {

/// Cuts the first line off the text and returns it.
std::string_view take_line(std::string_view& text) {
    const std::size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
    return line;
}

} // namespace

void require_same_study(std::string_view stored, std::string_view current,
                        const std::string& where) {
    if (stored == current)
        return;
    for (int line = 1; !stored.empty() || !current.empty(); ++line) {
        const std::string_view there = take_line(stored);
        const std::string_view here = take_line(current);
        if (there != here)
            throw core::InputError(fmt::format(
                "{} belongs to another study: line {} of the configuration is \"{}\" there and "
                "\"{}\" here; use another output folder, or the unchanged study to resume",
                where, line, there, here));
    }
    throw core::InputError(fmt::format(
        "{} belongs to another study: the configurations differ in their last line break", where));
}

} // namespace culm::archive
