// SPDX-License-Identifier: BSD-3-Clause
// video.toml: what is known of a recording before it is tracked.
#pragma once

#include "measure/frame_image.hpp"
#include "measure/measurement.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace culm::measure {

/// Empty: to be detected. Rows and columns are those of the frame, counted from 0 at the top left,
/// whole numbers at pixel centres.
struct TrackSettings {
    std::filesystem::path file;
    std::string frames; ///< where they are, relative to the file's folder (open_frames)
    std::optional<int> first_frame;
    std::optional<int> frame_count;
    std::optional<double> fps;       ///< of the camera, 1/s
    double metres_per_pixel = 0.0;   ///< m
    std::optional<int> width;        ///< of the frames, pixels; only checked
    std::optional<int> height;       ///< of the frames, pixels; only checked
    std::optional<Up> up;            ///< from the clamp to the tip
    std::optional<double> clamp;     ///< row (of a sideways stem: column) where the stem is clamped
    std::optional<double> axis;      ///< column (of a sideways stem: row) of the stem at rest
    std::optional<int> pull_sign;    ///< +1: the stem is pulled toward larger columns (rows)
    std::optional<Band> band;        ///< of coloured frames
    std::optional<int> stem_sign;    ///< +1: brighter than the background, −1: darker
    std::optional<double> threshold; ///< contrast to the background that makes a pixel the stem's
    std::vector<double> heights;     ///< above the clamp, m; empty: evenly spaced
    std::optional<double> height_step; ///< m
    int rows_per_height = 5;
    std::optional<int> release_frame;         ///< the last one in which the stem is held
    std::optional<int> frames_before_release; ///< kept of those before; empty: 50 at most
    bool trim_after_rest = true;
    std::vector<int> missing_frames; ///< numbers that the camera left out without leaving a gap
    Measurement description;         ///< stem, release, gravity; no times and deflections
};

/// Reads video.toml (format: docs/tracking.md). Throws core::InputError with every fault.
[[nodiscard]] TrackSettings read_track_settings(const std::filesystem::path& file);

} // namespace culm::measure
