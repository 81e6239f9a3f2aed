// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/frame_period.hpp"

#include <algorithm>
#include <vector>

namespace culm::calibrate {

double frame_period(const measure::Measurement& measurement) {
    if (measurement.frames_per_second)
        return 1.0 / *measurement.frames_per_second;
    std::vector<double> distances;
    for (std::size_t i = 1; i < measurement.times.size(); ++i)
        distances.push_back(measurement.times[i] - measurement.times[i - 1]);
    if (distances.empty())
        return 0.0;
    const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
    std::ranges::nth_element(distances, middle);
    return *middle;
}

} // namespace culm::calibrate
