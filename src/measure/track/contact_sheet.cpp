// SPDX-License-Identifier: BSD-3-Clause
#include "core/error.hpp"
#include "measure/track/frames/frame_from_opencv.hpp"
#include "measure/track/frames/frame_source.hpp"
#include "measure/track/track_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/core.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace culm::measure {
namespace {

// Blue, green, red.
constexpr std::array<double, 3> axis_colour{60, 255, 60};
constexpr std::array<double, 3> rest_colour{255, 200, 80};
constexpr std::array<double, 3> clamp_colour{80, 80, 255};
constexpr std::array<double, 3> text_colour{235, 235, 235};
constexpr int columns = 8;
constexpr int rows = 2;
// Drawing coordinates in sixteenths of a pixel.
constexpr int shift_bits = 4;

cv::Scalar ink(const std::array<double, 3>& colour) {
    return {colour[0], colour[1], colour[2]};
}

cv::Point fine_point(double x, double y) {
    return {int(std::lround(x * 16.0)), int(std::lround(y * 16.0))};
}

void write_text(cv::Mat& picture, const std::string& text, cv::Point place, double scale = 0.4) {
    // The dark outline makes the text readable on any picture.
    cv::putText(picture, text, place, cv::FONT_HERSHEY_SIMPLEX, scale, {0, 0, 0}, 3, cv::LINE_AA);
    cv::putText(picture, text, place, cv::FONT_HERSHEY_SIMPLEX, scale, ink(text_colour), 1,
                cv::LINE_AA);
}

/// Frame k of the record, enlarged, with the tracked axis.
cv::Mat paint_frame(const FrameImage& frame, std::size_t k, const Track& track,
                    double enlargement) {
    cv::Mat picture = picture_from(frame);
    cv::resize(picture, picture, {}, enlargement, enlargement,
               enlargement > 1.0 ? cv::INTER_LINEAR : cv::INTER_AREA);
    const StemSurvey& survey = track.survey;
    // Position of a point of the upright picture; pixel centres are whole numbers in both.
    const auto place = [&](double column, double row) {
        const PixelPoint point =
            in_frame({column, row}, survey.frame_width, survey.frame_height, survey.view.up);
        // cv::resize enlarges about the corner of the first pixel; coordinates count from its
        // centre.
        return fine_point((point.column + 0.5) * enlargement - 0.5,
                          (point.row + 0.5) * enlargement - 0.5);
    };
    const double axis = survey.trace.axis_column;
    const double reach = 3.0 * survey.trace.stem_width;
    cv::line(picture, place(axis - reach, survey.clamp_row), place(axis + reach, survey.clamp_row),
             ink(clamp_colour), 1, cv::LINE_AA, shift_bits);
    const std::vector<double>& heights = track.heights.places;
    for (std::size_t h = 0; h < heights.size(); ++h)
        if (const double rest = track.window.rest[h]; !std::isnan(rest))
            cv::circle(picture, place(rest, survey.clamp_row - heights[h]), 14, ink(rest_colour),
                       cv::FILLED, cv::LINE_AA, shift_bits);
    for (std::size_t r = 1; r < track.rows.places.size(); ++r) {
        const double upper = track.rows.at(k, r - 1);
        const double lower = track.rows.at(k, r);
        if (!std::isnan(upper) && !std::isnan(lower))
            cv::line(picture, place(upper, double(r) - 1.0), place(lower, double(r)),
                     ink(axis_colour), 1, cv::LINE_AA, shift_bits);
    }
    for (std::size_t h = 0; h < heights.size(); ++h)
        if (const double column = track.heights.at(k, h); !std::isnan(column))
            cv::circle(picture, place(column, survey.clamp_row - heights[h]), 48, ink(axis_colour),
                       1, cv::LINE_AA, shift_bits);
    return picture;
}

/// Frames of the sheet: two before the release, six of the first swing, the others evenly spaced.
std::vector<std::size_t> frames_of_sheet(const Track& track) {
    constexpr std::size_t count = std::size_t(columns) * std::size_t(rows);
    const std::size_t held = track.window.last_held;
    std::vector<std::size_t> chosen{track.first_kept, held};
    // A wrong release or a lost axis is visible in the first swing, so it gets six frames.
    for (int k = 1; k <= 6; ++k)
        chosen.push_back(held + std::size_t(std::lround(track.window.period() * k / 6.0)));
    for (auto& frame : chosen)
        frame = std::min(frame, track.last_kept);
    const std::size_t begin = chosen.back();
    const std::size_t left = count - chosen.size();
    for (std::size_t k = 1; k <= left; ++k)
        chosen.push_back(begin + (track.last_kept - begin) * k / left);
    return chosen;
}

} // namespace

void write_contact_sheet(const std::filesystem::path& file, const Track& track) {
    const auto source = open_frames(track.settings.file.parent_path(), track.settings.frames);
    const std::vector<std::size_t> chosen = frames_of_sheet(track);
    // A column of the sheet is some 240 pixels wide.
    const double enlargement = std::clamp(240.0 / track.survey.frame_width, 0.1, 3.0);
    std::vector<cv::Mat> tiles(chosen.size());
    std::vector<std::size_t> unique = chosen;
    // With a short record some frames are repeated; each is read once.
    unique.erase(std::unique(unique.begin(), unique.end()), unique.end());
    std::vector<std::size_t> indices;
    for (const std::size_t k : unique)
        indices.push_back(track.source_indices[k]);
    source->for_each(indices, 1, [&](std::size_t i, const FrameImage& frame) {
        cv::Mat tile = paint_frame(frame, unique[i], track, enlargement);
        const double time =
            (track.rows.times[unique[i]] - track.window.release.time) / track.frames_per_second;
        write_text(tile, fmt::format("{}  {:.2f} ms", track.rows.numbers[unique[i]], time * 1e3),
                   {6, 14});
        for (std::size_t k = 0; k < chosen.size(); ++k)
            if (chosen[k] == unique[i])
                tiles[k] = tile;
    });
    const cv::Size tile = tiles.front().size();
    cv::Mat sheet(rows * tile.height, columns * tile.width, CV_8UC3);
    for (int k = 0; k < columns * rows; ++k)
        tiles[std::size_t(k)].copyTo(
            sheet(cv::Rect({k % columns * tile.width, k / columns * tile.height}, tile)));
    bool is_written = false;
    try {
        is_written = cv::imwrite(file.string(), sheet);
    } catch (const cv::Exception&) {
        is_written = false;
    }
    if (!is_written)
        throw core::StorageError(fmt::format("{}: cannot be written", file.string()));
}

} // namespace culm::measure
