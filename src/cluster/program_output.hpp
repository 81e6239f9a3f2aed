// SPDX-License-Identifier: BSD-3-Clause
// What another program prints.
#pragma once

#include <chrono>
#include <string>
#include <vector>

namespace culm::cluster {

/// Runs the program named by the first word (looked up in PATH) with the others as its arguments,
/// without a shell, and returns its standard output of at most 64 kB. Empty if it cannot be
/// started, fails, or takes longer than `patience`; it is ended then.
[[nodiscard]] std::string program_output(const std::vector<std::string>& words,
                                         std::chrono::milliseconds patience);

} // namespace culm::cluster
