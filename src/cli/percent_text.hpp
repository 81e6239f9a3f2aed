// SPDX-License-Identifier: BSD-3-Clause
// Shares as people read them.
#pragma once

#include <cmath>
#include <string>

#include <fmt/core.h>

namespace culm::cli {

/// "+74 %", "-0.71 %"; "0 %" below a hundredth of a percent; "-" for NaN.
[[nodiscard]] inline std::string percent_text(double share) {
    const double percent = 100.0 * share;
    if (std::isnan(percent))
        return "-";
    if (std::abs(percent) < 0.01)
        return "0 %";
    return std::abs(percent) < 10.0 ? fmt::format("{:+.2g} %", percent)
                                    : fmt::format("{:+.0f} %", percent);
}

} // namespace culm::cli
