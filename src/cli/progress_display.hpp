// SPDX-License-Identifier: BSD-3-Clause
// Progress of a study: a line that rewrites itself on a terminal, sparse lines in a log.
#pragma once

#include "cli/text_style.hpp"
#include "farm/summary.hpp"

#include <chrono>
#include <cstdint>

namespace culm::cli {

class ProgressDisplay {
  public:
    /// On a terminal (stderr) every call redraws one line; elsewhere a line is printed when a tenth
    /// of the work or `log_interval` has passed. `items` is what the farm's points are.
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
    TextStyle style_ = TextStyle::of(stderr);
    bool quiet_;
    bool terminal_;
    bool line_is_open_ = false;
    std::int64_t last_tenth_ = -1;
    std::chrono::steady_clock::time_point last_line_ = std::chrono::steady_clock::now();
};

} // namespace culm::cli
