// SPDX-License-Identifier: BSD-3-Clause
#include "measure/folder/observation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace culm::measure {

namespace {

// The four neighbours are two on each side of the point, except in the first and last interval: an
// interpolating cubic is most accurate between its middle nodes.

/// First of the `points` neighbours of a point; `above` is the first node at or beyond it.
std::size_t first_of_stencil(std::size_t above, std::size_t points, std::size_t count) {
    const std::size_t centred = above >= 2 ? above - 2 : 0;
    return std::min(centred, count - points);
}

/// Weights of the values at `nodes` in the derivatives 0 … Count − 1 of their interpolating
/// polynomial at `place`: the Lagrange polynomials Π (x − xⱼ)/(xᵢ − xⱼ), and the product rule
/// factor by factor.
template <std::size_t Count>
std::array<std::array<double, 4>, Count> lagrange_weights(std::span<const double> nodes,
                                                          double place) {
    std::array<std::array<double, 4>, Count> weights{};
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        weights[0][i] = 1.0;
        for (std::size_t j = 0; j < nodes.size(); ++j) {
            if (j == i)
                continue;
            const double distance = nodes[i] - nodes[j];
            const double factor = (place - nodes[j]) / distance;
            for (std::size_t d = Count - 1; d > 0; --d)
                weights[d][i] = weights[d][i] * factor + double(d) * weights[d - 1][i] / distance;
            weights[0][i] *= factor;
        }
    }
    return weights;
}

constexpr double unseen = std::numeric_limits<double>::quiet_NaN();

/// At `place` the cubic through four points: the sum by lagrange_weights() without arrays, because
/// a diagnosis calls it for every sample of every run.
double cubic_through(double x0, double y0, double x1, double y1, double x2, double y2, double x3,
                     double y3, double place) {
    const double d0 = place - x0;
    const double d1 = place - x1;
    const double d2 = place - x2;
    const double d3 = place - x3;
    const double h01 = x0 - x1;
    const double h02 = x0 - x2;
    const double h03 = x0 - x3;
    const double h12 = x1 - x2;
    const double h13 = x1 - x3;
    const double h23 = x2 - x3;
    return y0 * (d1 * d2 * d3) / (h01 * h02 * h03) - y1 * (d0 * d2 * d3) / (h01 * h12 * h13) +
           y2 * (d0 * d1 * d3) / (h02 * h12 * h23) - y3 * (d0 * d1 * d2) / (h03 * h13 * h23);
}

/// Lateral position at `place` of the curve through the spheres about it. `above` is the first
/// sphere at or beyond it, and node(i) the place of sphere i.
template <class Node>
double lateral_position(std::span<const double> positions, std::size_t stride, std::size_t above,
                        double place, const Node& node) {
    const std::size_t count = positions.size() / stride;
    const std::size_t spheres = std::min<std::size_t>(4, count);
    const std::size_t first = first_of_stencil(above, spheres, count);
    const auto lateral = [&](std::size_t i) { return positions[i * stride + 1]; };
    if (spheres == 4)
        return cubic_through(node(first), lateral(first), node(first + 1), lateral(first + 1),
                             node(first + 2), lateral(first + 2), node(first + 3),
                             lateral(first + 3), place);
    std::array<double, 4> nodes{};
    for (std::size_t k = 0; k < spheres; ++k)
        nodes[k] = node(first + k);
    const auto [weights] = lagrange_weights<1>(std::span(nodes).first(spheres), place);
    double sum = 0.0;
    for (std::size_t k = 0; k < spheres; ++k)
        sum += weights[k] * lateral(first + k);
    return sum;
}

/// First of `count` spheres at or beyond a place on the undeformed stem, in bonds, but not the one
/// in the clamp; empty if the place is outside the chain.
std::optional<std::size_t> sphere_above(double place, std::size_t count) {
    if (!(place >= 0.0) || place > static_cast<double>(count) - 0.5)
        return std::nullopt;
    return std::clamp(static_cast<std::size_t>(std::ceil(place)), std::size_t{1}, count - 1);
}

double weighted_sum(const TimeStencil& stencil, const std::array<double, 4>& weights,
                    std::span<const double> table, std::size_t columns, std::size_t j) {
    if (stencil.samples == 0)
        return unseen;
    double sum = 0.0;
    for (std::size_t k = 0; k < stencil.samples; ++k)
        sum += weights[k] * table[(stencil.first + k) * columns + j];
    return sum;
}

/// A first-order low-pass filter of time constant `lag`, s.
void smooth(double lag, double interval, std::span<double> samples) {
    // The output of a ramp from x0 to x1 over h: decayed y0 + a x0 + b x1.
    const double decayed = std::exp(-interval / lag);
    const double mean = lag / interval * (1.0 - decayed);
    double before = samples.empty() ? 0.0 : samples.front();
    double output = before;
    for (double& sample : samples.subspan(samples.empty() ? 0 : 1)) {
        output = decayed * output + (mean - decayed) * before + (1.0 - mean) * sample;
        before = sample;
        sample = output;
    }
}

} // namespace

double deflection_in_row(std::span<const double> positions, int dimensions, double height) {
    const auto stride = static_cast<std::size_t>(dimensions);
    const std::size_t count = positions.size() / stride;
    if (height < positions[0] || height > positions[(count - 1) * stride])
        return unseen;
    std::size_t above = 1;
    while (above + 1 < count && positions[above * stride] < height)
        ++above;
    // The nodes are the spheres' current heights: the row is fixed, the material is not.
    return lateral_position(positions, stride, above, height,
                            [&](std::size_t i) { return positions[i * stride]; });
}

double deflection_of_mark(std::span<const double> positions, int dimensions, double bond_length,
                          double height) {
    const auto stride = static_cast<std::size_t>(dimensions);
    const double place = height / bond_length;
    const std::optional<std::size_t> above = sphere_above(place, positions.size() / stride);
    // The nodes are the spheres' positions along the undeformed stem, in bonds.
    return above ? lateral_position(positions, stride, *above, place,
                                    [](std::size_t i) { return static_cast<double>(i); })
                 : unseen;
}

double reading_of_sensor(const Sensor& sensor, const ChainSample& chain, int dimensions,
                         double bond_length, double height,
                         const SensorSurroundings& surroundings) {
    const auto stride = static_cast<std::size_t>(dimensions);
    const std::size_t count = chain.positions.size() / stride;
    const double place = height / bond_length;
    const auto above = count < 4 ? std::nullopt : sphere_above(place, count);
    if (!above)
        return unseen;
    const std::size_t first = first_of_stencil(*above, 4, count);
    constexpr std::array nodes{0.0, 1.0, 2.0, 3.0};
    const auto [value, slope, bend] =
        lagrange_weights<3>(nodes, place - static_cast<double>(first));
    const auto sum = [&](std::span<const double> values, const std::array<double, 4>& by,
                         std::size_t axis) {
        double total = 0.0;
        for (std::size_t k = 0; k < 4; ++k)
            total += by[k] * values[(first + k) * stride + axis];
        return total;
    };
    const double along = sum(chain.positions, slope, 0);
    const double aside = sum(chain.positions, slope, 1);
    const double stretch = std::hypot(along, aside);
    const double sine = aside / stretch;
    const double cosine = along / stretch;
    switch (sensor.quantity) {
    case Quantity::Displacement:
        return sum(chain.positions, value, 1) + sensor.distance_from_axis * (cosine - 1.0);
    case Quantity::Velocity:
        return sum(chain.velocities, value, 1) + surroundings.support_velocity;
    case Quantity::Acceleration: {
        const auto [axial_gravity, gravity] = surroundings.gravity;
        const double axial = sum(chain.accelerations, value, 0) - axial_gravity;
        const double lateral =
            sum(chain.accelerations, value, 1) + surroundings.support_acceleration - gravity;
        return lateral * cosine - axial * sine + gravity;
    }
    case Quantity::Strain:
        break;
    }
    const double curvature =
        (along * sum(chain.positions, bend, 1) - aside * sum(chain.positions, bend, 0)) /
        (stretch * stretch * stretch);
    return -sensor.distance_from_axis * curvature;
}

void filter(const Sensor& sensor, double interval, std::span<double> samples) {
    if (sensor.low_pass > 0.0)
        smooth(0.5 / (std::numbers::pi * sensor.low_pass), interval, samples);
    if (sensor.high_pass > 0.0) {
        std::vector<double> slow(samples.begin(), samples.end());
        smooth(0.5 / (std::numbers::pi * sensor.high_pass), interval, slow);
        for (std::size_t k = 0; k < samples.size(); ++k)
            samples[k] -= slow[k];
    }
}

double TimeStencil::value(std::span<const double> table, std::size_t columns, std::size_t j) const {
    return weighted_sum(*this, weights, table, columns, j);
}

double TimeStencil::rate(std::span<const double> table, std::size_t columns, std::size_t j) const {
    return weighted_sum(*this, rates, table, columns, j);
}

TimeStencil time_stencil(std::span<const double> sample_times, double time) {
    TimeStencil stencil;
    const std::size_t count = sample_times.size();
    if (count == 0)
        return stencil;
    if (time <= sample_times.front()) {
        stencil.samples = 1;
        stencil.weights[0] = 1.0;
        return stencil;
    }
    const double tolerance = 1e-9 * (sample_times.back() - sample_times.front());
    if (time > sample_times.back() + tolerance)
        return stencil;
    const auto found = std::ranges::lower_bound(sample_times, time);
    const auto above = std::min(static_cast<std::size_t>(found - sample_times.begin()), count - 1);
    stencil.samples = std::min<std::size_t>(4, count);
    stencil.first = first_of_stencil(above, stencil.samples, count);
    const auto nodes = sample_times.subspan(stencil.first, stencil.samples);
    const auto [weights, rates] = lagrange_weights<2>(nodes, time);
    stencil.weights = weights;
    stencil.rates = rates;
    return stencil;
}

} // namespace culm::measure
