// SPDX-License-Identifier: BSD-3-Clause
#include "measure/curve_reading.hpp"

#include <algorithm>
#include <cmath>

namespace culm::measure {

namespace {

/// First of the `points` neighbours of which `above` is the first at or beyond the place.
std::size_t first_of_stencil(std::size_t above, std::size_t points, std::size_t count) {
    const std::size_t centred = above >= 2 ? above - 2 : 0;
    return std::min(centred, count - points);
}

/// Weights of the values at `nodes` in their interpolating polynomial at `place`.
std::array<double, 4> lagrange_weights(std::span<const double> nodes, double place) {
    std::array<double, 4> weights{};
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        weights[i] = 1.0;
        for (std::size_t j = 0; j < nodes.size(); ++j)
            if (j != i)
                weights[i] *= (place - nodes[j]) / (nodes[i] - nodes[j]);
    }
    return weights;
}

/// Slope of the polynomial through (nodes, values) at node i.
double slope_at_node(std::span<const double> nodes, std::span<const double> values, std::size_t i) {
    double slope = 0.0;
    for (std::size_t j = 0; j < nodes.size(); ++j) {
        if (j == i)
            continue;
        double ratio = 1.0; // of the barycentric weights of j and i
        for (std::size_t k = 0; k < nodes.size(); ++k)
            if (k != i && k != j)
                ratio *= (nodes[i] - nodes[k]) / (nodes[j] - nodes[k]);
        slope += (values[i] - ratio * values[j]) / (nodes[i] - nodes[j]);
    }
    return slope;
}

} // namespace

double CurveReading::derivative(std::span<const double> position_derivatives,
                                int dimensions) const {
    const auto stride = static_cast<std::size_t>(dimensions);
    double sum = 0.0;
    for (std::size_t k = 0; k < spheres; ++k) {
        const std::size_t at = (first_sphere + k) * stride;
        sum +=
            by_axial[k] * position_derivatives[at] + by_lateral[k] * position_derivatives[at + 1];
    }
    return sum;
}

CurveReading read_row(std::span<const double> positions, int dimensions, double height) {
    const auto stride = static_cast<std::size_t>(dimensions);
    const std::size_t count = positions.size() / stride;
    CurveReading reading;
    if (height < positions[0] || height > positions[(count - 1) * stride])
        return reading;
    std::size_t above = 1;
    while (above + 1 < count && positions[above * stride] < height)
        ++above;
    reading.spheres = std::min<std::size_t>(4, count);
    reading.first_sphere = first_of_stencil(above, reading.spheres, count);
    std::array<double, 4> axial{};
    std::array<double, 4> lateral{};
    for (std::size_t k = 0; k < reading.spheres; ++k) {
        axial[k] = positions[(reading.first_sphere + k) * stride];
        lateral[k] = positions[(reading.first_sphere + k) * stride + 1];
    }
    const std::span nodes(axial.data(), reading.spheres);
    const std::span values(lateral.data(), reading.spheres);
    reading.by_lateral = lagrange_weights(nodes, height);
    reading.deflection = 0.0;
    for (std::size_t k = 0; k < reading.spheres; ++k) {
        reading.deflection += reading.by_lateral[k] * lateral[k];
        // Moving a node along with the curve changes nothing; so moving it alone does the opposite
        // of moving its value by the slope.
        reading.by_axial[k] = -reading.by_lateral[k] * slope_at_node(nodes, values, k);
    }
    return reading;
}

CurveReading read_mark(std::span<const double> positions, int dimensions, double bond_length,
                       double height) {
    const auto stride = static_cast<std::size_t>(dimensions);
    const std::size_t count = positions.size() / stride;
    const double place = height / bond_length;
    CurveReading reading;
    if (!(place >= 0.0) || place > static_cast<double>(count) - 0.5)
        return reading;
    const auto above =
        std::clamp(static_cast<std::size_t>(std::ceil(place)), std::size_t{1}, count - 1);
    reading.spheres = std::min<std::size_t>(4, count);
    reading.first_sphere = first_of_stencil(above, reading.spheres, count);
    std::array<double, 4> nodes{};
    for (std::size_t k = 0; k < reading.spheres; ++k)
        nodes[k] = static_cast<double>(reading.first_sphere + k);
    reading.by_lateral = lagrange_weights(std::span(nodes.data(), reading.spheres), place);
    reading.deflection = 0.0;
    for (std::size_t k = 0; k < reading.spheres; ++k)
        reading.deflection +=
            reading.by_lateral[k] * positions[(reading.first_sphere + k) * stride + 1];
    return reading;
}

} // namespace culm::measure
