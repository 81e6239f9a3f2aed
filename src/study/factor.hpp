// SPDX-License-Identifier: BSD-3-Clause
// A parameter that varies over a study, and the values that it takes.
#pragma once

#include "study/distribution.hpp"
#include "study/parameter_table.hpp"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace culm::study {

/// The levels of a list or a stepped range, in SI, in the order of the config. In a design of type
/// `list` from [[design.point]]: the value at each point.
using Levels = std::vector<double>;

/// Normal scatter of the tests of one stem about the stem's own value, confined to [min, max]; SI.
struct WithinStemScatter {
    double sd = 0.0;
    double min = 0.0;
    double max = 0.0;
};

/// Where the values of an empirical distribution come from.
struct MeasuredColumn {
    std::string file;   ///< as written in the study
    std::string column; ///< its header
    bool keeps_rows = false;
};

struct Factor {
    const Parameter* parameter = nullptr;
    std::variant<Levels, Distribution> values;
    /// Does every replicate draw a new value? True for distributions; false for lists and ranges,
    /// whose values belong to the design point.
    bool is_redrawn = false;
    /// Drawn for every test of a stem, or once for the stem?
    bool is_per_test = false;
    std::optional<WithinStemScatter> within_stem = {};
    std::optional<MeasuredColumn> measured = {}; ///< of an empirical distribution

    /// Maps 0 < u < 1 to a value in SI: levels are equally probable, distributions are inverted.
    [[nodiscard]] double quantile(double u) const {
        if (const auto* distribution = std::get_if<Distribution>(&values))
            return distribution->quantile(u);
        const auto& levels = std::get<Levels>(values);
        const auto count = static_cast<double>(levels.size());
        return levels[std::min(static_cast<std::size_t>(u * count), levels.size() - 1)];
    }

    /// The name of the coordinate of the unit cube that selects the value: columns whose rows stay
    /// together have that of their file in common.
    [[nodiscard]] std::string_view coordinate() const {
        return measured && measured->keeps_rows ? std::string_view(measured->file) : parameter->key;
    }
};

} // namespace culm::study
