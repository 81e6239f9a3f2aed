// SPDX-License-Identifier: BSD-3-Clause
#include "cli/progress.hpp"

#include "present/text.hpp"

#include <cstdio>
#include <string>

#include <fmt/core.h>
#include <unistd.h>

namespace culm::cli {
namespace {

std::string line_of(const farm::Progress& progress, const char* items) {
    const double rate = progress.elapsed_s > 0.0
                            ? static_cast<double>(progress.points_done) / progress.elapsed_s
                            : 0.0;
    std::string line = fmt::format("{}/{} {}, {:.3g} {}/s", progress.points_done,
                                   progress.points_total, items, rate, items);
    if (progress.failed > 0)
        line += fmt::format(", {} failed", progress.failed);
    if (progress.points_done < progress.points_total && progress.estimated_remaining_s)
        line += fmt::format(", {} left", present::estimate_text(*progress.estimated_remaining_s));
    return line;
}

std::string bar_of(const farm::Progress& progress) {
    constexpr std::int64_t width = 24; // characters
    const std::int64_t filled = width * progress.points_done / progress.points_total;
    return fmt::format("[{:#<{}}{:.<{}}] ", "", filled, "", width - filled);
}

} // namespace

RewrittenLine::RewrittenLine(bool is_quiet) : is_quiet_(is_quiet), is_terminal_(::isatty(2) == 1) {}

void RewrittenLine::finish() {
    if (line_is_open_)
        fmt::print(stderr, "\n");
    line_is_open_ = false;
}

void RewrittenLine::rewrite(const std::string& line) {
    fmt::print(stderr, "\r\033[K{}", line);
    std::fflush(stderr);
    line_is_open_ = true;
}

ProgressDisplay::ProgressDisplay(bool is_quiet, const char* items)
    : RewrittenLine(is_quiet), items_(items) {}

void ProgressDisplay::show(const farm::Progress& progress) {
    constexpr std::chrono::minutes log_interval{1};
    if (is_quiet_ || progress.points_total == 0)
        return;
    if (is_terminal_) {
        rewrite(bar_of(progress) + line_of(progress, items_));
        return;
    }
    const std::int64_t tenth = 10 * progress.points_done / progress.points_total;
    const auto now = std::chrono::steady_clock::now();
    if (tenth == last_tenth_ && now - last_line_ < log_interval)
        return;
    last_tenth_ = tenth;
    last_line_ = now;
    fmt::print(stderr, "{}\n", line_of(progress, items_));
}

std::string StepDisplay::elapsed() const {
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start_;
    return fmt::format("{:6.1f} s", passed.count());
}

void StepDisplay::begin(const std::string& step) {
    step_ = step;
    last_line_ = std::chrono::steady_clock::now();
    if (is_quiet_)
        return;
    if (is_terminal_)
        rewrite(fmt::format("{}  {}", elapsed(), step_));
    else
        fmt::print(stderr, "{}  {}\n", elapsed(), step_);
}

void StepDisplay::keep_alive() {
    if (!step_.empty() &&
        std::chrono::steady_clock::now() - last_line_ > std::chrono::seconds(is_terminal_ ? 1 : 60))
        begin(step_);
}

void StepDisplay::show(const farm::Progress& progress) {
    if (is_quiet_ || !is_terminal_ || progress.points_total < 2)
        return;
    rewrite(fmt::format("{}  {}: {}/{}", elapsed(), step_, progress.points_done,
                        progress.points_total));
}

} // namespace culm::cli
