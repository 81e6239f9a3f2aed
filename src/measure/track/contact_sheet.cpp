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
#include <opencv2/videoio.hpp>

namespace culm::measure {
namespace {

// Blue, green, red.
constexpr std::array<double, 3> axis_colour{60, 255, 60};
constexpr std::array<double, 3> rest_colour{255, 200, 80};
constexpr std::array<double, 3> clamp_colour{80, 80, 255};
constexpr std::array<double, 3> text_colour{235, 235, 235};
constexpr std::array<double, 3> paper_colour{30, 30, 30};
constexpr int columns = 8;
constexpr int rows = 2;
constexpr int plot_height = 320;
constexpr int margin = 60;
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

/// Deflections over time, one line per height, from blue (low) to red (high).
cv::Mat paint_histories(const Measurement& measurement, int width) {
    cv::Mat plot(plot_height, width, CV_8UC3, ink(paper_colour));
    double largest = 0.0;
    for (const double value : measurement.deflections)
        if (std::abs(value) > largest)
            largest = std::abs(value);
    largest = std::max(largest, 1e-9);
    const double first = measurement.times.front();
    const double span = std::max(1e-9, measurement.times.back() - first);
    const auto x_of = [&](double time) {
        return margin + (time - first) / span * (width - 2 * margin);
    };
    const auto y_of = [&](double value) {
        return 0.5 * plot_height - value / largest * (0.5 * plot_height - 40.0);
    };
    const auto line = [&](double x1, double y1, double x2, double y2, const cv::Scalar& colour) {
        cv::line(plot, fine_point(x1, y1), fine_point(x2, y2), colour, 1, cv::LINE_AA, shift_bits);
    };
    line(margin, y_of(0.0), width - margin, y_of(0.0), {110, 110, 110});
    line(x_of(0.0), 30, x_of(0.0), plot_height - 30, {110, 110, 110});
    for (std::size_t h = 0; h < measurement.heights.size(); ++h) {
        const double part =
            double(h) / double(std::max<std::size_t>(1, measurement.heights.size() - 1));
        const cv::Scalar colour(255.0 * (1.0 - part) + 60.0 * part,
                                170.0 - 80.0 * std::abs(2.0 * part - 1.0), 255.0 * part);
        for (std::size_t k = 1; k < measurement.times.size(); ++k) {
            const double before = measurement.deflection(k - 1, h);
            const double now = measurement.deflection(k, h);
            if (!std::isnan(before) && !std::isnan(now))
                line(x_of(measurement.times[k - 1]), y_of(before), x_of(measurement.times[k]),
                     y_of(now), colour);
        }
    }
    write_text(plot,
               fmt::format("{}: deflection at {} heights, {:.4g} ... {:.4g} mm above the clamp; "
                           "full scale +-{:.3g} mm; {:.4g} ... {:.4g} s, vertical line: release",
                           measurement.stem.id, measurement.heights.size(),
                           measurement.heights.front() * 1e3, measurement.heights.back() * 1e3,
                           largest * 1e3, first, measurement.times.back()),
               {margin, 20});
    return plot;
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

/// Positions in the source of the frames with these indices in the record.
std::vector<std::size_t> source_positions(const FrameSource& source, const Track& track,
                                          const std::vector<std::size_t>& chosen) {
    const int first = track.settings.first_frame.value_or(source.numbers().front());
    const auto begin =
        std::size_t(std::ranges::lower_bound(source.numbers(), first) - source.numbers().begin());
    std::vector<std::size_t> positions;
    for (const std::size_t k : chosen)
        positions.push_back(begin + k);
    return positions;
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
    source->for_each(
        source_positions(*source, track, unique), 1, [&](std::size_t i, const FrameImage& frame) {
            cv::Mat tile = paint_frame(frame, unique[i], track, enlargement);
            const double time =
                (track.rows.times[unique[i]] - track.window.release.time) / track.frames_per_second;
            write_text(tile,
                       fmt::format("{}  {:.2f} ms", track.rows.numbers[unique[i]], time * 1e3),
                       {6, 14});
            for (std::size_t k = 0; k < chosen.size(); ++k)
                if (chosen[k] == unique[i])
                    tiles[k] = tile;
        });
    const cv::Size tile = tiles.front().size();
    cv::Mat sheet(rows * tile.height + plot_height, columns * tile.width, CV_8UC3,
                  ink(paper_colour));
    for (int k = 0; k < columns * rows; ++k)
        tiles[std::size_t(k)].copyTo(
            sheet(cv::Rect({k % columns * tile.width, k / columns * tile.height}, tile)));
    paint_histories(track.measurement, sheet.cols)
        .copyTo(sheet(cv::Rect(0, rows * tile.height, sheet.cols, plot_height)));
    bool is_written = false;
    try {
        is_written = cv::imwrite(file.string(), sheet);
    } catch (const cv::Exception&) {
        is_written = false;
    }
    if (!is_written)
        throw core::StorageError(fmt::format("{}: cannot be written", file.string()));
}

void write_overlay_video(const std::filesystem::path& file, const Track& track) {
    const auto source = open_frames(track.settings.file.parent_path(), track.settings.frames);
    const double enlargement = std::clamp(std::floor(800.0 / track.survey.frame_height), 1.0, 3.0);
    std::vector<std::size_t> chosen;
    for (std::size_t k = track.first_kept; k <= track.last_kept; ++k)
        chosen.push_back(k);
    cv::VideoWriter video;
    source->for_each(
        source_positions(*source, track, chosen), 1, [&](std::size_t i, const FrameImage& frame) {
            const cv::Mat picture = paint_frame(frame, chosen[i], track, enlargement);
            if (!video.isOpened())
                video.open(file.string(), cv::CAP_OPENCV_MJPEG,
                           cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 25.0, picture.size());
            video.write(picture);
        });
    if (!video.isOpened())
        throw core::StorageError(fmt::format("{}: cannot be written", file.string()));
}

} // namespace culm::measure
