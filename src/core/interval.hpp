// SPDX-License-Identifier: BSD-3-Clause
// A range of allowed numbers with open or closed ends.
#pragma once

#include <cmath>
#include <string>

#include <fmt/format.h>

namespace culm::core {

struct Interval {
    double low = 0.0;
    double high = 0.0;
    bool low_open = false;  ///< `low` itself is not allowed
    bool high_open = false; ///< `high` itself is not allowed

    /// False for NaN and infinities, whatever the ends are.
    [[nodiscard]] bool contains(double value) const {
        return std::isfinite(value) && (low_open ? value > low : value >= low) &&
               (high_open ? value < high : value <= high);
    }
    /// In mathematical notation, for example "(0, 1000]".
    [[nodiscard]] std::string text() const {
        return fmt::format("{}{}, {}{}", low_open ? '(' : '[', low, high, high_open ? ')' : ']');
    }
};

} // namespace culm::core
