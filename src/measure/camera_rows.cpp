// SPDX-License-Identifier: BSD-3-Clause
#include "measure/camera_rows.hpp"

#include <algorithm>
#include <limits>

namespace culm::measure {

double deflection_in_row(std::span<const double> positions, int dimensions, double height) {
    const auto stride = static_cast<std::size_t>(dimensions);
    const std::size_t count = positions.size() / stride;
    const auto axial = [&](std::size_t i) { return positions[i * stride]; };
    const auto lateral = [&](std::size_t i) { return positions[i * stride + 1]; };
    if (height < axial(0) || height > axial(count - 1))
        return std::numeric_limits<double>::quiet_NaN();

    std::size_t above = 1; // the first centre at or above the row
    while (above + 1 < count && axial(above) < height)
        ++above;
    const std::size_t points = std::min<std::size_t>(4, count);
    const std::size_t centred = above >= 2 ? above - 2 : 0;
    const std::size_t begin = std::min(centred, count - points);

    double deflection = 0.0;
    for (std::size_t i = begin; i < begin + points; ++i) {
        double weight = 1.0;
        for (std::size_t j = begin; j < begin + points; ++j)
            if (j != i)
                weight *= (height - axial(j)) / (axial(i) - axial(j));
        deflection += weight * lateral(i);
    }
    return deflection;
}

std::vector<double> deflections_in_rows(std::span<const double> positions, int dimensions,
                                        std::span<const double> heights) {
    std::vector<double> deflections;
    deflections.reserve(heights.size());
    for (const double height : heights)
        deflections.push_back(deflection_in_row(positions, dimensions, height));
    return deflections;
}

} // namespace culm::measure
