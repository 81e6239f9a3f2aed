// SPDX-License-Identifier: BSD-3-Clause
#include "cli/progress_display.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include <fmt/core.h>
#include <unistd.h>

namespace culm::cli {
namespace {

std::string duration_text(double seconds) {
    if (seconds >= 3600.0)
        return fmt::format("{:.1f} h", seconds / 3600.0);
    const long whole = std::max(std::lround(seconds), 1L);
    return whole < 60 ? fmt::format("{} s", whole)
                      : fmt::format("{} min {:02} s", whole / 60, whole % 60);
}

std::string line_of(const farm::Progress& progress) {
    const double rate = progress.elapsed_s > 0.0
                            ? static_cast<double>(progress.points_done) / progress.elapsed_s
                            : 0.0;
    std::string line = fmt::format("{}/{} points, {:.3g} points/s", progress.points_done,
                                   progress.points_total, rate);
    if (progress.failed > 0)
        line += fmt::format(", {} failed", progress.failed);
    if (progress.points_done < progress.points_total && progress.estimated_remaining_s)
        line += fmt::format(", {} left", duration_text(*progress.estimated_remaining_s));
    return line;
}

std::string bar_of(const farm::Progress& progress) {
    constexpr std::int64_t width = 24; // characters
    const std::int64_t filled = width * progress.points_done / progress.points_total;
    return fmt::format("[{:#<{}}{:.<{}}] ", "", filled, "", width - filled);
}

} // namespace

ProgressDisplay::ProgressDisplay(bool quiet) : quiet_(quiet), terminal_(::isatty(2) == 1) {}

void ProgressDisplay::show(const farm::Progress& progress) {
    if (quiet_ || progress.points_total == 0)
        return;
    if (terminal_) {
        fmt::print(stderr, "\r\033[K{}{}", bar_of(progress), line_of(progress));
        std::fflush(stderr);
        line_is_open_ = true;
        return;
    }
    const std::int64_t tenth = 10 * progress.points_done / progress.points_total;
    const auto now = std::chrono::steady_clock::now();
    if (tenth == last_tenth_ && now - last_line_ < log_interval)
        return;
    last_tenth_ = tenth;
    last_line_ = now;
    fmt::print(stderr, "{}\n", line_of(progress));
}

void ProgressDisplay::finish() {
    if (line_is_open_)
        fmt::print(stderr, "\n");
    line_is_open_ = false;
}

} // namespace culm::cli
