// SPDX-License-Identifier: BSD-3-Clause
// Progress on standard error: a line that rewrites itself on a terminal, sparse lines in a log.
#pragma once

#include "farm/summary.hpp"

#include <chrono>
#include <cstdint>
#include <string>

namespace culm::cli {

/// A line on standard error that rewrites itself if that is a terminal.
class RewrittenLine {
  public:
    explicit RewrittenLine(bool is_quiet);
    ~RewrittenLine() { finish(); }
    RewrittenLine(const RewrittenLine&) = delete;
    RewrittenLine& operator=(const RewrittenLine&) = delete;

    /// Ends the line on a terminal.
    void finish();

  protected:
    void rewrite(const std::string& line);

    bool is_quiet_;
    bool is_terminal_;

  private:
    bool line_is_open_ = false;
};

/// Progress of a study, or of other items that a farm computes.
class ProgressDisplay : public RewrittenLine {
  public:
    /// On a terminal every call redraws one line; elsewhere a line is printed after each tenth of
    /// the work or after a minute. `items` is the name of the farm's points.
    explicit ProgressDisplay(bool is_quiet, const char* items = "points");

    void show(const farm::Progress& progress);

  private:
    const char* items_;
    std::int64_t last_tenth_ = -1;
    std::chrono::steady_clock::time_point last_line_ = std::chrono::steady_clock::now();
};

/// Progress of a command with named steps, each of some items: one line that rewrites itself on a
/// terminal, else a line for each step.
class StepDisplay : public RewrittenLine {
  public:
    using RewrittenLine::RewrittenLine;

    void begin(const std::string& step);
    void show(const farm::Progress& progress);
    /// Shows the time within a long step: each second on a terminal, elsewhere each minute.
    void keep_alive();

  private:
    [[nodiscard]] std::string elapsed() const;

    std::string step_;
    std::chrono::steady_clock::time_point last_line_ = std::chrono::steady_clock::now();
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

} // namespace culm::cli
