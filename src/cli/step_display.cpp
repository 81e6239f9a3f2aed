// SPDX-License-Identifier: BSD-3-Clause
#include "cli/step_display.hpp"

#include <cstdio>

#include <fmt/core.h>
#include <unistd.h>

namespace culm::cli {

StepDisplay::StepDisplay(bool is_quiet) : is_quiet_(is_quiet), is_terminal_(::isatty(2) == 1) {}

StepDisplay::~StepDisplay() {
    if (line_is_open_)
        std::fputc('\n', stderr);
}

std::string StepDisplay::elapsed() const {
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start_;
    return fmt::format("{:6.1f} s", passed.count());
}

void StepDisplay::rewrite(const std::string& line) {
    fmt::print(stderr, "\r\033[K{}", line);
    std::fflush(stderr);
    line_is_open_ = true;
}

void StepDisplay::begin(const std::string& step) {
    step_ = step;
    if (is_quiet_)
        return;
    if (is_terminal_)
        rewrite(fmt::format("{}  {}", elapsed(), step_));
    else
        fmt::print(stderr, "{}  {}\n", elapsed(), step_);
}

void StepDisplay::show(const farm::Progress& progress) {
    if (is_quiet_ || !is_terminal_ || progress.points_total < 2)
        return;
    rewrite(fmt::format("{}  {}: {}/{}", elapsed(), step_, progress.points_done,
                        progress.points_total));
}

} // namespace culm::cli
