// SPDX-License-Identifier: BSD-3-Clause
#include "measure/camera_rows.hpp"

#include "measure/curve_reading.hpp"

namespace culm::measure {

double deflection_in_row(std::span<const double> positions, int dimensions, double height) {
    return read_row(positions, dimensions, height).deflection;
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
