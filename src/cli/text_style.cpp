// SPDX-License-Identifier: BSD-3-Clause
#include "cli/text_style.hpp"

#include "farm/environment.hpp"

#include <cstdlib>

#include <fmt/color.h>
#include <unistd.h>

namespace culm::cli {
namespace {

/// The value of an environment variable; empty if it is not set.
std::string_view environment(const char* name) {
    const char* value = std::getenv(name);
    return value == nullptr ? std::string_view() : std::string_view(value);
}

std::string styled(bool is_coloured, const fmt::text_style& style, std::string_view text) {
    return is_coloured ? fmt::format(style, "{}", text) : std::string(text);
}

} // namespace

TextStyle TextStyle::of(std::FILE* stream) {
    TextStyle style;
    const std::string_view terminal = environment("TERM");
    // Launchers give their processes a terminal of their own, wherever the output goes in the end.
    style.is_coloured_ = ::isatty(::fileno(stream)) == 1 &&
                         !farm::Environment::is_under_launcher() && !terminal.empty() &&
                         terminal != "dumb" && environment("NO_COLOR").empty();
    return style;
}

std::string TextStyle::verdict(std::string_view text) const {
    return styled(is_coloured_, fmt::emphasis::bold, text);
}

std::string TextStyle::good(std::string_view text) const {
    return styled(is_coloured_, fmt::fg(fmt::terminal_color::green), text);
}

std::string TextStyle::warning(std::string_view text) const {
    return styled(is_coloured_, fmt::fg(fmt::terminal_color::yellow), text);
}

std::string TextStyle::failure(std::string_view text) const {
    return styled(is_coloured_, fmt::fg(fmt::terminal_color::red), text);
}

std::string TextStyle::headline(std::string_view text) const {
    const std::size_t colon = text.find(':');
    if (colon == std::string_view::npos)
        return std::string(text);
    return verdict(text.substr(0, colon + 1)) + std::string(text.substr(colon + 1));
}

std::string TextStyle::finding(std::string_view text) const {
    return text == "fits"                   ? good(text)
           : text == "something is missing" ? warning(text)
           : text.starts_with("failed")     ? failure(text)
                                            : std::string(text);
}

void print_error(std::string_view reason) {
    fmt::print(stderr, "{} {}\n", TextStyle::of(stderr).failure("culm:"), reason);
}

void print_note(std::string_view text) {
    fmt::print(stderr, "culm: {} {}\n", TextStyle::of(stderr).warning("note:"), text);
}

void print_warning(std::string_view text) {
    fmt::print(stderr, "culm: {} {}\n", TextStyle::of(stderr).warning("warning:"), text);
}

} // namespace culm::cli
