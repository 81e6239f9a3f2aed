// SPDX-License-Identifier: BSD-3-Clause
#include "cli/motion_arrays.hpp"

#include <utility>

namespace culm::cli {

using archive::NamedArray;

NamedArray series(std::string path, std::string unit, std::string description,
                  std::vector<double> values) {
    const std::size_t count = values.size();
    return {std::move(path), std::move(unit), std::move(description), {count}, std::move(values)};
}

void add_measured(std::vector<NamedArray>& arrays, const std::string& place,
                  const fit::RecordingFit& fit, const measure::Measurement& measurement) {
    // With --window a fit has fewer frames than the recording.
    const std::size_t frames = fit.times.size();
    const std::size_t rows = measurement.heights.size();
    arrays.push_back(series(place + "time", "s", "0 is the release", fit.times));
    arrays.push_back(series(place + "height", "m", "above the clamp", measurement.heights));
    arrays.push_back(
        {place + "measured",
         "m",
         "deflection (time, height); NaN where nothing was seen",
         {frames, rows},
         {measurement.deflections.begin(),
          measurement.deflections.begin() + static_cast<std::ptrdiff_t>(frames * rows)}});
}

void add_predicted(std::vector<NamedArray>& arrays, const std::string& group,
                   const fit::RecordingFit& fit) {
    const std::vector<std::size_t> map{fit.times.size(), fit.prediction.rows};
    arrays.push_back(
        {group + "/predicted", "m", "deflection (time, height)", map,
         std::vector<double>(fit.prediction.readings.begin(), fit.prediction.readings.end())});
    arrays.push_back({group + "/residual", "m",
                      "measured - predicted (time, height); NaN where nothing was seen", map,
                      fit.residuals});
}

} // namespace culm::cli
