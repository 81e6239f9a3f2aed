// SPDX-License-Identifier: BSD-3-Clause
#include "run/rolling_shutter.hpp"

#include <algorithm>
#include <cmath>

namespace culm::run {
namespace {

/// Cubic through the four samples about `place` (in sample intervals); constant beyond the ends.
double interpolated(const std::vector<double>& samples, double place) {
    const double base = std::floor(place);
    const double u = place - base;
    const auto at = [&](int offset) {
        const double index =
            std::clamp(base + offset, 0.0, static_cast<double>(samples.size() - 1));
        return samples[static_cast<std::size_t>(index)];
    };
    return -u * (u - 1.0) * (u - 2.0) / 6.0 * at(-1) +
           (u + 1.0) * (u - 1.0) * (u - 2.0) / 2.0 * at(0) -
           (u + 1.0) * u * (u - 2.0) / 2.0 * at(1) + (u + 1.0) * u * (u - 1.0) / 6.0 * at(2);
}

} // namespace

std::size_t late_samples(double readout_time, double sample_interval) {
    if (readout_time <= 0.0)
        return 0;
    return static_cast<std::size_t>(std::ceil(readout_time / sample_interval)) + 2;
}

void read_late(std::vector<double>& history, std::span<const double> heights,
               double delay_per_height, double interval) {
    if (heights.empty())
        return;
    const std::size_t samples = history.size() / heights.size();
    std::vector<double> column(samples);
    for (std::size_t row = 0; row < heights.size(); ++row) {
        for (std::size_t k = 0; k < samples; ++k)
            column[k] = history[k * heights.size() + row];
        const double shift = delay_per_height * heights[row] / interval;
        for (std::size_t k = 0; k < samples; ++k)
            history[k * heights.size() + row] =
                interpolated(column, static_cast<double>(k) + shift);
    }
}

} // namespace culm::run
