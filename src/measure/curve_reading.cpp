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

/// The spheres about a row and their weights in it.
struct RowStencil {
    std::size_t first_sphere = 0;
    std::size_t spheres = 0; ///< 0 if there is nothing to be seen
    std::array<double, 4> axial{};
    std::array<double, 4> lateral{};
    std::array<double, 4> weights{};

    [[nodiscard]] double deflection() const {
        if (spheres == 0)
            return std::numeric_limits<double>::quiet_NaN();
        double sum = 0.0;
        for (std::size_t k = 0; k < spheres; ++k)
            sum += weights[k] * lateral[k];
        return sum;
    }
};

RowStencil row_stencil(std::span<const double> positions, int dimensions, double height) {
    const auto stride = static_cast<std::size_t>(dimensions);
    const std::size_t count = positions.size() / stride;
    RowStencil stencil;
    if (height < positions[0] || height > positions[(count - 1) * stride])
        return stencil;
    std::size_t above = 1;
    while (above + 1 < count && positions[above * stride] < height)
        ++above;
    stencil.spheres = std::min<std::size_t>(4, count);
    stencil.first_sphere = first_of_stencil(above, stencil.spheres, count);
    for (std::size_t k = 0; k < stencil.spheres; ++k) {
        stencil.axial[k] = positions[(stencil.first_sphere + k) * stride];
        stencil.lateral[k] = positions[(stencil.first_sphere + k) * stride + 1];
    }
    stencil.weights = lagrange_weights(std::span(stencil.axial.data(), stencil.spheres), height);
    return stencil;
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
    CurveReading reading;
    const RowStencil stencil = row_stencil(positions, dimensions, height);
    if (stencil.spheres == 0)
        return reading;
    reading.deflection = stencil.deflection();
    reading.first_sphere = stencil.first_sphere;
    reading.spheres = stencil.spheres;
    reading.by_lateral = stencil.weights;
    // Moving a node along with the curve changes nothing; so moving it alone does the opposite of
    // moving its value by the slope.
    for (std::size_t k = 0; k < stencil.spheres; ++k)
        reading.by_axial[k] = -stencil.weights[k] *
                              slope_at_node(std::span(stencil.axial.data(), stencil.spheres),
                                            std::span(stencil.lateral.data(), stencil.spheres), k);
    return reading;
}

double deflection_in_row(std::span<const double> positions, int dimensions, double height) {
    return row_stencil(positions, dimensions, height).deflection();
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
