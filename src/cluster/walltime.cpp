// SPDX-License-Identifier: BSD-3-Clause
#include "cluster/walltime.hpp"

#include "core/error.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/core.h>

namespace culm::cluster {

namespace {

constexpr double day = 86400.0;
/// A limit beyond a year is treated as a typing error.
constexpr double longest = 366.0 * day;

/// A whole number of at most six digits.
std::optional<double> whole_number(std::string_view text) {
    int value = 0;
    const char* end = text.data() + text.size();
    const auto [stopped, error] = std::from_chars(text.data(), end, value);
    if (text.empty() || text.size() > 6 || text.front() == '-' || error != std::errc() ||
        stopped != end)
        return std::nullopt;
    return value;
}

std::vector<std::string_view> split(std::string_view text, char separator) {
    std::vector<std::string_view> parts;
    for (std::size_t end = 0; (end = text.find(separator)) != std::string_view::npos;) {
        parts.push_back(text.substr(0, end));
        text.remove_prefix(end + 1);
    }
    parts.push_back(text);
    return parts;
}

/// `parts` of a clock time; the unit of the first is `unit` seconds, that of each next a sixtieth.
std::optional<double> clock_seconds(const std::vector<std::string_view>& parts, double unit) {
    double seconds = 0.0;
    for (const std::string_view part : parts) {
        const std::optional<double> value = whole_number(part);
        if (!value)
            return std::nullopt;
        seconds += *value * unit;
        unit /= 60.0;
    }
    return seconds;
}

std::optional<double> days_and_clock(std::string_view text) {
    const std::size_t dash = text.find('-');
    if (dash == std::string_view::npos) {
        const auto parts = split(text, ':');
        if (parts.size() < 2 || parts.size() > 3)
            return std::nullopt;
        // As Slurm reads a limit: two parts are minutes and seconds, after a dash they are hours
        // and minutes.
        return clock_seconds(parts, parts.size() == 3 ? 3600.0 : 60.0);
    }
    const auto days = whole_number(text.substr(0, dash));
    const auto parts = split(text.substr(dash + 1), ':');
    if (!days || parts.size() > 3)
        return std::nullopt;
    const auto clock = clock_seconds(parts, 3600.0);
    return clock ? std::optional(*days * day + *clock) : std::nullopt;
}

std::optional<double> number_with_unit(std::string_view text) {
    constexpr std::array<std::pair<std::string_view, double>, 5> units = {
        {{"min", 60.0}, {"s", 1.0}, {"m", 60.0}, {"h", 3600.0}, {"d", day}}};
    for (const auto& [name, seconds] : units) {
        if (!text.ends_with(name))
            continue;
        double value = 0.0;
        const char* end = text.data() + text.size() - name.size();
        const auto [stopped, error] = std::from_chars(text.data(), end, value);
        if (error == std::errc() && stopped == end && std::isfinite(value))
            return value * seconds;
    }
    return std::nullopt;
}

} // namespace

double parse_walltime(std::string_view what, const std::string& text) {
    std::optional<double> seconds = number_with_unit(text);
    if (!seconds)
        seconds = days_and_clock(text);
    if (!seconds || !(*seconds > 0.0) || *seconds > longest)
        throw core::InputError(fmt::format(
            "{}: \"{}\" is not a duration above zero and of at most a year; allowed are HH:MM:SS, "
            "MM:SS, D-HH, D-HH:MM, D-HH:MM:SS, or a number with its unit: 90s, 45min, 12h, 2d",
            what, text));
    return *seconds;
}

std::optional<double> parse_time_left(std::string_view text) {
    constexpr std::string_view blank = " \t\r\n";
    const std::size_t first = text.find_first_not_of(blank);
    if (first == std::string_view::npos)
        return std::nullopt;
    text = text.substr(first, text.find_last_not_of(blank) - first + 1);
    return days_and_clock(text);
}

std::string walltime_text_in_hours(double seconds) {
    const auto whole = static_cast<long long>(std::ceil(seconds));
    return fmt::format("{:02d}:{:02d}:{:02d}", whole / 3600, whole / 60 % 60, whole % 60);
}

std::string walltime_text(double seconds) {
    if (seconds < day)
        return walltime_text_in_hours(seconds);
    const double days = std::floor(seconds / day);
    return fmt::format("{:.0f}-{}", days, walltime_text_in_hours(seconds - days * day));
}

} // namespace culm::cluster
