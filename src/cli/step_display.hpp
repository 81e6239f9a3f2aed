// SPDX-License-Identifier: BSD-3-Clause
// Progress of a command that goes through named steps, each of some items.
#pragma once

#include "farm/summary.hpp"

#include <chrono>
#include <string>

namespace culm::cli {

/// On a terminal (stderr) one line that rewrites itself; elsewhere a line for each step.
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
