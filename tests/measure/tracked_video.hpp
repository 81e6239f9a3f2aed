// SPDX-License-Identifier: BSD-3-Clause
// Tracks a rendered video and compares it with what was rendered.
#pragma once

#include "measure/rendered_video.hpp"
#include "measure/track/track.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace culm::measure {

inline Track track_rendered(const RenderedVideo& video, const std::string& extra = "",
                            Up up = Up::DecreasingRow, int threads = 2) {
    const tests::TemporaryFolder folder;
    return track_video(read_track_settings(video.write(folder, extra, up)), {threads});
}

/// Differences between the measurement and the truth, in pixels of the video.
struct TrackError {
    double rms = 0.0;
    double largest = 0.0;
    double seen = 0.0;             ///< fraction of the cells
    double over_uncertainty = 0.0; ///< root mean square of error over what is stated
};

/// `clamp_row` as the measurement has it: the height's zero.
inline TrackError error_of(const Track& track, const RenderedVideo& video) {
    const Measurement& measurement = track.measurement;
    const double px = rendered_mm_per_px * 1e-3;
    const double lift = video.clamp_row - track.survey.clamp_row;
    TrackError error;
    std::size_t count = 0;
    for (std::size_t k = 0; k < measurement.times.size(); ++k)
        for (std::size_t h = 0; h < measurement.heights.size(); ++h) {
            const double value = measurement.deflection(k, h) / px;
            if (std::isnan(value))
                continue;
            const double truth = video.mean_deflection(measurement.heights[h] / px + lift,
                                                       track.rows.numbers[track.first_kept + k]);
            error.rms += (value - truth) * (value - truth);
            if (!measurement.reading_uncertainties.empty())
                error.over_uncertainty += std::pow(
                    (value - truth) * px /
                        measurement.reading_uncertainties[k * measurement.heights.size() + h],
                    2);
            error.largest = std::max(error.largest, std::abs(value - truth));
            ++count;
        }
    error.rms = std::sqrt(error.rms / double(std::max<std::size_t>(1, count)));
    error.over_uncertainty =
        std::sqrt(error.over_uncertainty / double(std::max<std::size_t>(1, count)));
    error.seen = double(count) / double(measurement.deflections.size());
    return error;
}

/// Whether some remark contains the text.
inline bool has_remark(const Track& track, const std::string& text) {
    return std::ranges::any_of(track.remarks, [&](const std::string& remark) {
        return remark.find(text) != std::string::npos;
    });
}

} // namespace culm::measure
