// SPDX-License-Identifier: BSD-3-Clause
// The current time in the format of provenance.
#pragma once

#include <array>
#include <ctime>
#include <string>

namespace culm::core {

/// "2026-11-21T23:59:07Z": ISO 8601, universal time.
[[nodiscard]] inline std::string utc_now_text() {
    const std::time_t now = std::time(nullptr);
    std::tm parts{};
    ::gmtime_r(&now, &parts);
    std::array<char, 32> text{};
    const std::size_t length =
        std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &parts);
    return {text.data(), length};
}

} // namespace culm::core
