// SPDX-License-Identifier: BSD-3-Clause
#include "measure/observation.hpp"

#include <algorithm>
#include <limits>

namespace culm::measure {

namespace {

double weighted_sum(const TimeStencil& stencil, const std::array<double, 4>& weights,
                    std::span<const double> table, std::size_t columns, std::size_t j) {
    if (stencil.samples == 0)
        return std::numeric_limits<double>::quiet_NaN();
    double sum = 0.0;
    for (std::size_t k = 0; k < stencil.samples; ++k)
        sum += weights[k] * table[(stencil.first + k) * columns + j];
    return sum;
}

/// Weight of node i at `time` and its derivative by time.
void set_weight(std::span<const double> nodes, double time, std::size_t i, TimeStencil& stencil) {
    double weight = 1.0;
    double rate = 0.0;
    for (std::size_t j = 0; j < nodes.size(); ++j) {
        if (j == i)
            continue;
        const double distance = nodes[i] - nodes[j];
        rate = rate * (time - nodes[j]) / distance + weight / distance;
        weight *= (time - nodes[j]) / distance;
    }
    stencil.weights[i] = weight;
    stencil.rates[i] = rate;
}

} // namespace

std::vector<CurveReading> read_frame(const ObservedPlaces& places,
                                     std::span<const double> positions) {
    std::vector<CurveReading> readings;
    readings.reserve(places.heights.size());
    for (const double height : places.heights)
        readings.push_back(
            places.reading == Reading::Row
                ? read_row(positions, places.dimensions, height)
                : read_mark(positions, places.dimensions, places.bond_length, height));
    return readings;
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
    stencil.first = std::min(above >= 2 ? above - 2 : 0, count - stencil.samples);
    const auto nodes = sample_times.subspan(stencil.first, stencil.samples);
    for (std::size_t i = 0; i < stencil.samples; ++i)
        set_weight(nodes, time, i, stencil);
    return stencil;
}

std::vector<double> resampled_in_time(std::span<const double> sample_times,
                                      std::span<const double> table, std::span<const double> times,
                                      std::vector<double>* rates) {
    const std::size_t columns = sample_times.empty() ? 0 : table.size() / sample_times.size();
    std::vector<double> values;
    values.reserve(times.size() * columns);
    if (rates != nullptr)
        rates->clear();
    for (const double time : times) {
        const TimeStencil stencil = time_stencil(sample_times, time);
        for (std::size_t j = 0; j < columns; ++j) {
            values.push_back(stencil.value(table, columns, j));
            if (rates != nullptr)
                rates->push_back(stencil.rate(table, columns, j));
        }
    }
    return values;
}

} // namespace culm::measure
