// SPDX-License-Identifier: BSD-3-Clause
#include "cluster/batch_system.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <fmt/core.h>
#include <unistd.h>

namespace culm::cluster {

namespace {

constexpr std::size_t longest_output = 65536;

/// Whether the text consists of digits only, like job numbers and times in seconds.
bool is_number(const std::string& text) {
    return !text.empty() && text.size() <= 18 &&
           std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

std::optional<TimeLeft> slurm_time_left(const BatchSystemAccess& access) {
    const std::string job = access.variable("SLURM_JOB_ID");
    if (!is_number(job))
        return std::nullopt;
    if (const std::string end = access.variable("SLURM_JOB_END_TIME"); is_number(end))
        return TimeLeft{std::stod(end) - access.now(), "SLURM_JOB_END_TIME"};
    const std::string answer =
        access.output_of("squeue --noheader --jobs=" + job + " --Format=TimeLeft");
    const std::optional<double> left = parse_time_left(answer);
    return left ? std::optional(TimeLeft{*left, "squeue, job " + job}) : std::nullopt;
}

std::optional<TimeLeft> pbs_time_left(const BatchSystemAccess& access) {
    const std::string limit = access.variable("PBS_WALLTIME");
    if (access.variable("PBS_JOBID").empty() || !is_number(limit))
        return std::nullopt;
    return TimeLeft{std::stod(limit) - access.session_age(), "PBS_WALLTIME"};
}

/// Field 22 of /proc/PID/stat: ticks from the start of the machine to that of the process.
double start_ticks(::pid_t process) {
    std::ifstream in(fmt::format("/proc/{}/stat", process));
    std::string text;
    std::getline(in, text);
    // The name of the program is field 2, in parentheses, and may itself contain any character.
    std::istringstream fields(text.substr(std::min(text.size(), text.rfind(')') + 1)));
    std::string field;
    for (int k = 3; k <= 22; ++k)
        if (!(fields >> field))
            return 0.0;
    return std::strtod(field.c_str(), nullptr);
}

double age_of_session() {
    double uptime = 0.0;
    std::ifstream("/proc/uptime") >> uptime;
    const double start = start_ticks(::getsid(0));
    const double ticks_per_second = static_cast<double>(::sysconf(_SC_CLK_TCK));
    return start > 0.0 ? std::max(0.0, uptime - start / ticks_per_second) : 0.0;
}

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

std::string program_output(const std::string& command, std::chrono::milliseconds patience) {
    // Without the user's terminal a query that asks for a password cannot wait there.
    std::FILE* const pipe =
        ::popen(fmt::format("timeout --signal=KILL {:.3f} {} </dev/null 2>/dev/null",
                            std::chrono::duration<double>(patience).count(), command)
                    .c_str(),
                "re");
    if (pipe == nullptr)
        return "";
    std::string text(longest_output, '\0');
    text.resize(std::fread(text.data(), 1, text.size(), pipe));
    // A busy controller may not answer for minutes; culm then computes without its answer.
    return ::pclose(pipe) == 0 && text.size() < longest_output ? text : "";
}

BatchSystemAccess real_batch_system() {
    return {[](const std::string& name) {
                const char* value = std::getenv(name.c_str());
                return std::string(value == nullptr ? "" : value);
            },
            [](const std::string& command) {
                return program_output(command, std::chrono::seconds(10));
            },
            [] {
                const auto since_1970 = std::chrono::system_clock::now().time_since_epoch();
                return std::chrono::duration<double>(since_1970).count();
            },
            age_of_session};
}

std::optional<TimeLeft> time_left_of_job(const BatchSystemAccess& access) {
    if (auto left = slurm_time_left(access))
        return left;
    return pbs_time_left(access);
}

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

std::string walltime_text(double seconds) {
    const auto whole = static_cast<long long>(std::ceil(seconds));
    const std::string clock =
        fmt::format("{:02d}:{:02d}:{:02d}", whole / 3600 % 24, whole / 60 % 60, whole % 60);
    return whole < 86400 ? clock : fmt::format("{}-{}", whole / 86400, clock);
}

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
