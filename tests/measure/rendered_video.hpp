// SPDX-License-Identifier: BSD-3-Clause
// Renders small videos of a vibrating stem whose position in every row is known exactly.
#pragma once

#include "measure/track/frames/frame_image.hpp"
#include "support/temporary_folder.hpp"

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

namespace culm::measure {

/// A stem that is held in a cantilever's static shape, released from rest, and swings in that
/// shape with damping. Its edges are error functions of the distance from the axis, evaluated
/// without integration, so that the axis is exact in every row.
struct RenderedVideo {
    int width = 120;
    int height = 200;
    double clamp_row = 190.0;
    double axis_column = 60.0;
    double length = 160.0;   ///< pixels
    double stem_width = 5.0; ///< pixels
    double pull = 24.0;      ///< of the tip, pixels
    double frames_per_cycle = 16.0;
    double decay_per_cycle = 0.8;
    double release_frame = 10.4; ///< the stem is released between frames 10 and 11
    int frames = 150;
    double background = 60.0;
    double contrast = 120.0; ///< negative: a dark stem
    double blur = 0.9;       ///< pixels
    double noise = 3.0;      ///< grey values
    double exposure = 0.0;   ///< frames
    double lit_side = 0.0;   ///< share by which the right edge is brighter than the middle
    unsigned seed = 1;
    std::array<double, 3> colour{1.0, 1.0, 1.0}; ///< contrast in red, green and blue
    bool is_coloured = false;
    /// Changes the picture (64-bit floating point, 1 or 3 channels blue, green, red) before noise.
    std::function<void(cv::Mat&, int frame)> decorate;

    /// Deflection at a height above the clamp, pixels.
    [[nodiscard]] double deflection(double height_px, double frame) const;
    /// Its mean over the exposure.
    [[nodiscard]] double mean_deflection(double height_px, int frame) const;
    /// 8-bit picture; noise depends on seed and frame alone.
    [[nodiscard]] cv::Mat picture(int frame) const;
    /// Lines of video.toml; `extra` goes into [video].
    [[nodiscard]] std::string settings(const std::string& extra = "") const;
    /// Writes frames/%05d.png and video.toml; returns the latter. Pictures may be turned.
    std::filesystem::path write(const tests::TemporaryFolder& folder, const std::string& extra = "",
                                Up up = Up::DecreasingRow) const;

  private:
    [[nodiscard]] std::vector<double> moments(int frame) const; ///< of the exposure
};

/// Scale and rate of all rendered videos.
inline constexpr double rendered_mm_per_px = 0.5;
inline constexpr double rendered_fps = 960.0;

} // namespace culm::measure
