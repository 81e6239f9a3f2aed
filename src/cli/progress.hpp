// SPDX-License-Identifier: BSD-3-Clause
// Progress on standard error: a line that rewrites itself on a terminal, sparse lines in a log.
#pragma once

#include "farm/summary.hpp"
#include "present/text_style.hpp"

#include <chrono>
#include <cstdint>
#include <string>

namespace culm::cli {

/// Progress of a study, or of other items that a farm computes.
class ProgressDisplay {
  public:
    /// On a terminal (stderr) every call redraws one line; elsewhere a line is printed after each
    /// tenth of the work or after `log_interval`. `items` is the name of the farm's points.
    explicit ProgressDisplay(bool quiet, const char* items = "points");

    ~ProgressDisplay() { finish(); }
    ProgressDisplay(const ProgressDisplay&) = delete;
    ProgressDisplay& operator=(const ProgressDisplay&) = delete;

    void show(const farm::Progress& progress);
    /// Ends the line on a terminal.
    void finish();

  private:
    static constexpr std::chrono::minutes log_interval{1};
    const char* items_;
    present::TextStyle style_;
    bool quiet_;
    bool terminal_;
    bool line_is_open_ = false;
    std::int64_t last_tenth_ = -1;
    std::chrono::steady_clock::time_point last_line_ = std::chrono::steady_clock::now();
};

/// Progress of a command with named steps, each of some items.
///
/// Shows one line that rewrites itself on a terminal (stderr), else a line for each step.
class StepDisplay {
  public:
    explicit StepDisplay(bool is_quiet);
    /// Ends the line on a terminal.
    ~StepDisplay();
    StepDisplay(const StepDisplay&) = delete;
    StepDisplay& operator=(const StepDisplay&) = delete;

    void begin(const std::string& step);
    void show(const farm::Progress& progress);

  private:
    [[nodiscard]] std::string elapsed() const;
    void rewrite(const std::string& line);

    bool is_quiet_;
    bool is_terminal_;
    bool line_is_open_ = false;
    std::string step_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

} // namespace culm::cli
