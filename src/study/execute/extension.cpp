// SPDX-License-Identifier: BSD-3-Clause
#include "study/execute/extension.hpp"

#include "core/error.hpp"
#include "study/config/study_config.hpp"

#include <algorithm>
#include <numeric>
#include <regex>

#include <fmt/format.h>

namespace culm::study {

namespace {

/// The design's points, ordered by their values, equal ones by their numbers.
std::vector<std::int64_t> ordered_by_values(const Design& design) {
    std::vector<std::int64_t> order(static_cast<std::size_t>(design.point_count()));
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, [&](std::int64_t a, std::int64_t b) {
        return std::ranges::lexicographical_compare(design.row(a), design.row(b));
    });
    return order;
}

[[noreturn]] void refuse(const Study& stored, const Study& now, const std::string& what) {
    const bool is_hypercube = now.config.design.type == DesignType::LatinHypercube;
    throw core::InputError(fmt::format(
        "{} does not extend the stored study: {}{}. What differs:\n{}Choose another folder with -o",
        now.config.file, what,
        is_hypercube ? "; a Latin hypercube with another number of points has other points" : "",
        difference(stored.config.identity(), now.config.identity())));
}

} // namespace

bool may_extend(const std::string& stored, const std::string& now) {
    // A line for each key that differs; the rows of the designs decide the rest.
    static const std::regex other_key(
        R"((^|\n)(?!(factors|design|replicates)\.|study\.heights_mm)[^\n])");
    return !std::regex_search(difference(stored, now), other_key);
}

ExtensionMap extension_of(const Study& stored, const Study& now) {
    const std::vector<double>& heights = now.config.base.heights;
    for (const double height : stored.config.base.heights)
        if (std::ranges::find(heights, height) == heights.end())
            refuse(stored, now, "it stores fewer heights");
    ExtensionMap map;
    map.adds_heights = heights != stored.config.base.heights;
    map.stored_point.assign(static_cast<std::size_t>(now.design.point_count()), -1);
    const std::vector<std::int64_t> candidates = ordered_by_values(now.design);
    auto candidate = candidates.begin();
    for (const std::int64_t point : ordered_by_values(stored.design)) {
        const auto row = stored.design.row(point);
        while (candidate != candidates.end() &&
               std::ranges::lexicographical_compare(now.design.row(*candidate), row))
            ++candidate;
        if (candidate == candidates.end() || !std::ranges::equal(now.design.row(*candidate), row))
            refuse(stored, now,
                   fmt::format("it lacks the stored point {}{}", point,
                               factors_text(stored.design, point)));
        map.stored_point[static_cast<std::size_t>(*candidate++)] = point;
    }
    return map;
}

} // namespace culm::study
