// SPDX-License-Identifier: BSD-3-Clause
// The failed points of a study as text.
#pragma once

#include "study/summary.hpp"

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include <fmt/core.h>

namespace culm::cli {

/// The first ten of them with their reasons; empty if there is none. summary.json has them all.
[[nodiscard]] inline std::string failed_points_text(const std::vector<study::FailedPoint>& failed,
                                                    std::int64_t points) {
    constexpr std::size_t listed = 10;
    if (failed.empty())
        return {};
    std::string text = fmt::format("\n{} of {} points failed:\n", failed.size(), points);
    for (std::size_t k = 0; k < std::min(listed, failed.size()); ++k)
        text += fmt::format("    point {}: {}: {}\n", failed[k].point, failed[k].kind,
                            failed[k].reason);
    if (failed.size() > listed)
        text += fmt::format("    … and {} more, see summary.json\n", failed.size() - listed);
    return text;
}

} // namespace culm::cli
