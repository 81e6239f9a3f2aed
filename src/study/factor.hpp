// SPDX-License-Identifier: BSD-3-Clause
// A parameter that varies over a study, and the values that it takes.
#pragma once

#include "study/distribution.hpp"
#include "study/parameter_table.hpp"

#include <algorithm>
#include <cstddef>
#include <variant>
#include <vector>

namespace culm::study {

/// The levels of a list or a stepped range, in SI, in the order of the config. In a design of type
/// `list` from [[design.point]]: the value at each point.
using Levels = std::vector<double>;

struct Factor {
    const Parameter* parameter = nullptr;
    std::variant<Levels, Distribution> values;
    /// Does every replicate draw a new value? True for distributions; false for lists and ranges,
    /// whose values belong to the design point.
    bool is_redrawn = false;

    /// Maps 0 < u < 1 to a value in SI: levels are equally probable, distributions are inverted.
    [[nodiscard]] double quantile(double u) const {
        if (const auto* distribution = std::get_if<Distribution>(&values))
            return distribution->quantile(u);
        const auto& levels = std::get<Levels>(values);
        const auto count = static_cast<double>(levels.size());
        return levels[std::min(static_cast<std::size_t>(u * count), levels.size() - 1)];
    }
};

} // namespace culm::study
