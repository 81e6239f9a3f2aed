// SPDX-License-Identifier: BSD-3-Clause
// Durations and sizes of files as people read them.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/core.h>

namespace culm::cli {

/// "12 s", "3 min 05 s", "1.5 h"; at least a second.
[[nodiscard]] inline std::string duration_text(double seconds) {
    if (seconds >= 3600.0)
        return fmt::format("{:.1f} h", seconds / 3600.0);
    const long whole = std::max(std::lround(seconds), 1L);
    return whole < 60 ? fmt::format("{} s", whole)
                      : fmt::format("{} min {:02} s", whole / 60, whole % 60);
}

/// Of what is only estimated, to two digits: "0.4 s", "40 s", "3 min", "1.5 h".
[[nodiscard]] inline std::string estimate_text(double seconds) {
    return seconds < 90.0     ? fmt::format("{:.2g} s", seconds)
           : seconds < 5400.0 ? fmt::format("{:.2g} min", seconds / 60.0)
                              : fmt::format("{:.2g} h", seconds / 3600.0);
}

/// "812 B", "12 kB", "3.4 MB", "1.2 GB".
[[nodiscard]] inline std::string bytes_text(double bytes) {
    return bytes < 1e3   ? fmt::format("{:.0f} B", bytes)
           : bytes < 1e6 ? fmt::format("{:.3g} kB", bytes * 1e-3)
           : bytes < 1e9 ? fmt::format("{:.3g} MB", bytes * 1e-6)
                         : fmt::format("{:.3g} GB", bytes * 1e-9);
}

} // namespace culm::cli
