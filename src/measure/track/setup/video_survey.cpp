// SPDX-License-Identifier: BSD-3-Clause
#include "core/error.hpp"
#include "core/order_statistics.hpp"
#include "measure/folder/measurement_files.hpp"
#include "measure/track/frames/frame_from_opencv.hpp"
#include "measure/track/track_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <span>

#include <boost/archive/iterators/base64_from_binary.hpp>
#include <boost/archive/iterators/transform_width.hpp>
#include <fmt/core.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace culm::measure {
namespace {

using json = nlohmann::ordered_json;

/// Pixels of all frames that the first pass reads: half a minute of two cores.
constexpr double most_pixels = 4e8;
constexpr std::size_t fewest_frames = 200;
constexpr std::array<double, 5> tried_widths{3.0, 6.0, 12.0, 24.0, 48.0}; // pixels

/// One pixel is taken for a millimetre, so that lengths are in pixels.
TrackSettings settings_of(const FrameSource& source, double width) {
    TrackSettings settings;
    settings.file = source.name();
    settings.metres_per_pixel = 1e-3;
    settings.description.stem.section = CircularSection{width * 1e-3, std::nullopt};
    return settings;
}

std::vector<std::size_t> first_frames(std::size_t count) {
    std::vector<std::size_t> frames(count);
    std::iota(frames.begin(), frames.end(), std::size_t{0});
    return frames;
}

Track traced(const FrameSource& source, std::span<const std::size_t> frames,
             const StemSurvey& survey, double width, int threads) {
    Track track;
    track.source = source.name();
    track.settings = settings_of(source, width);
    track.survey = survey;
    track.source_indices.assign(frames.begin(), frames.end());
    for (const std::size_t index : frames)
        track.rows.numbers.push_back(source.numbers()[index]);
    track.rows.times.assign(track.rows.numbers.begin(), track.rows.numbers.end());
    track_rows(track, source, threads);
    return track;
}

/// Rows in which the stem is seen, times its clarity; small if it is not as wide as assumed.
double quality(const Track& track, double width) {
    double seen = 0.0;
    for (std::size_t r = 0; r < track.rows.places.size(); ++r)
        seen += track.rows.seen(r);
    const double clarity = std::min(1.0, track.survey.contrast / (20.0 * track.survey.noise));
    const double mismatch = std::abs(std::log(track.survey.apparent_width / width));
    return seen * clarity / (1.0 + mismatch);
}

/// The survey of the clearest stem, and its width; throws core::InputError if there is none.
std::pair<StemSurvey, double> clearest_stem(const FrameSource& source, int threads) {
    const std::vector<std::size_t> sample =
        evenly_spaced(first_frames(source.numbers().size()), 12);
    std::optional<std::pair<StemSurvey, double>> best;
    double best_quality = 0.0;
    std::string reason;
    const auto look = [&](double width) {
        try {
            const StemSurvey survey =
                survey_stem(source, sample, settings_of(source, width), threads);
            const double found = quality(traced(source, sample, survey, width, threads), width);
            if (found > best_quality) {
                best_quality = found;
                best = {survey, width};
            }
        } catch (const core::InputError& error) {
            reason = error.what();
        }
    };
    for (const double width : tried_widths)
        look(width);
    if (!best)
        throw core::InputError(reason);
    look(best->first.apparent_width);
    return *best;
}

/// The frames of the first pass: all, or those about the release, which is where the stem first
/// leaves the position at which it is held.
std::vector<std::size_t> frames_to_trace(const FrameSource& source, const StemSurvey& survey,
                                         double width, int threads) {
    const std::size_t frames = source.numbers().size();
    const double pixels = double(survey.frame_width) * double(survey.frame_height);
    const auto most = std::max(fewest_frames, std::size_t(most_pixels / pixels));
    std::vector<std::size_t> wanted = first_frames(std::min(frames, most));
    if (frames <= most)
        return wanted;
    const std::vector<std::size_t> sample = evenly_spaced(first_frames(frames), most / 2);
    const Track coarse = traced(source, sample, survey, width, threads);
    // The row that moves farthest, of those that are seen at the start and in most frames.
    std::size_t moving = 0;
    double spread = 0.0;
    for (std::size_t r = 0; r < coarse.rows.places.size(); ++r) {
        if (std::isnan(coarse.rows.at(0, r)) || coarse.rows.seen(r) <= 0.9)
            continue;
        const std::vector<double> history = known(coarse.rows.history(r));
        if (const double found = core::quantile(history, 0.98) - core::quantile(history, 0.02);
            found > spread) {
            spread = found;
            moving = r;
        }
    }
    std::size_t first = 0;
    while (first + 1 < sample.size() &&
           !(std::abs(coarse.rows.at(first, moving) - coarse.rows.at(0, moving)) > 0.2 * spread))
        ++first;
    const std::size_t onset = sample[first == 0 ? 0 : first - 1];
    const std::size_t begin = std::min(onset - std::min(onset, most / 8), frames - most);
    std::ranges::for_each(wanted, [begin](std::size_t& index) { index += begin; });
    return wanted;
}

/// Upper edge of the tip: the rows below it are cut obliquely and have no reading.
double visible_tip(const Track& track) {
    const std::optional<double> row = tip_row(track);
    if (!row)
        return track.survey.clamp_row;
    const double hidden = *row > 2.0 ? oblique_rows(track.survey.trace.stem_width) + 0.5 : 0.0;
    return std::max(-0.5, *row - hidden);
}

/// Finds the release and the rest positions of all rows; the reason if that is impossible.
std::string find_motion(Track& track) {
    try {
        const std::vector<double> heights =
            spaced_heights(track.rows, track.survey.clamp_row, 0.0, 1.0);
        if (heights.empty())
            return "No row shows the stem in nine of ten frames, so the release was not detected.";
        set_heights(track, heights);
        track.window = find_ring_down(
            track.heights,
            {track.source, track.survey.clamp_row - visible_tip(track), std::nullopt});
        return {};
    } catch (const core::InputError& error) {
        return fmt::format("The release was not detected: {}", error.what());
    }
}

/// Positions in the track of frames that show the motion, with their captions.
std::map<std::size_t, std::string> shown_positions(const Track& track, bool has_motion) {
    const std::size_t frames = track.rows.numbers.size();
    std::map<std::size_t, std::string> shown;
    if (!has_motion) {
        for (const std::size_t position : evenly_spaced(first_frames(frames), 16))
            shown[position] = "";
        return shown;
    }
    const RingDownWindow& window = track.window;
    const std::size_t last_held = window.last_held;
    const std::vector<double> watched = track.heights.history(window.watched);
    const auto half_period =
        std::max<std::size_t>(2, std::size_t(0.5 / std::max(1e-6, window.cycles_per_frame())));
    // The largest deflection of each of the first half-periods.
    for (std::size_t half = 0; half < 8; ++half) {
        const std::size_t begin = last_held + 1 + half * half_period;
        const std::size_t end = std::min(frames, begin + half_period);
        std::size_t turning = begin;
        double largest = -1.0;
        for (std::size_t k = begin; k < end; ++k)
            if (const double size = std::abs(watched[k] - window.rest[window.watched]);
                size > largest) { // false for NaN
                largest = size;
                turning = k;
            }
        if (largest >= 0.0)
            shown[turning] = "turning point";
    }
    shown[0] = "first frame searched";
    shown[frames - 1] = "last frame searched";
    for (std::size_t after = 1; after <= 4 && last_held + after < frames; ++after)
        shown[last_held + after] = fmt::format("{} after the release", after);
    for (std::size_t before = 1; before <= std::min<std::size_t>(4, last_held); ++before)
        shown[last_held - before] = fmt::format("held, {} before the last", before);
    shown[last_held] = "held, the last frame before the release";
    return shown;
}

/// A hundredth of a pixel is more than a person can place.
double rounded(double pixels) {
    return std::round(pixels * 100.0) / 100.0;
}

/// A point of the upright picture as a point of the frame as recorded.
json point_json(const Track& track, double column, double row) {
    const PixelPoint point = in_frame({column, row}, track.survey.frame_width,
                                      track.survey.frame_height, track.survey.view.up);
    return json::array({rounded(point.column), rounded(point.row)});
}

/// The stem at rest and, if it is known, its motion.
json stem_json(const Track& track, bool has_motion) {
    const StemSurvey& survey = track.survey;
    const double rest = has_motion && !std::isnan(track.window.rest.back())
                            ? track.window.rest.back()
                            : survey.trace.axis_column;
    json out{{"up", to_string(survey.view.up)},
             {"clamp", point_json(track, survey.trace.axis_column, survey.clamp_row)},
             {"tip", point_json(track, rest, visible_tip(track))},
             {"channel", to_string(survey.view.band)},
             {"stem", survey.view.sign > 0 ? "bright" : "dark"},
             {"width_px", rounded(survey.apparent_width)},
             {"release_frame", nullptr},
             {"pull_side", nullptr},
             {"pull_px", nullptr},
             {"cycles_per_frame", nullptr}};
    if (has_motion) {
        out["release_frame"] = track.heights.numbers[track.window.last_held];
        out["pull_side"] = positive_side(track);
        out["pull_px"] = rounded(track.window.pull());
        out["cycles_per_frame"] = track.window.cycles_per_frame();
    }
    return out;
}

/// One frame that shows how the stem moves.
struct ShownFrame {
    std::size_t index; ///< in the source
    std::string caption;
    json axis; ///< points of the stem; empty where it was not seen
};

json axis_json(const Track& track, std::size_t position) {
    json axis = json::array();
    std::size_t seen = 0;
    for (std::size_t r = 0; r < track.rows.places.size(); ++r)
        // Every third row is enough for a drawing.
        if (const double column = track.rows.at(position, r);
            !std::isnan(column) && seen++ % 3 == 0)
            axis.push_back(point_json(track, column, double(r)));
    return axis;
}

std::string base64(const std::vector<std::uint8_t>& bytes) {
    using namespace boost::archive::iterators;
    using Encoder =
        base64_from_binary<transform_width<std::vector<std::uint8_t>::const_iterator, 6, 8>>;
    std::string text(Encoder(bytes.begin()), Encoder(bytes.end()));
    while (text.size() % 4 != 0)
        text += '=';
    return text;
}

std::string as_data_url(const FrameImage& frame) {
    constexpr double most_pixels = 900.0;
    cv::Mat picture = picture_from(frame);
    const double shrink = most_pixels / std::max(frame.width, frame.height);
    if (shrink < 1.0)
        cv::resize(picture, picture, {}, shrink, shrink, cv::INTER_AREA);
    std::vector<std::uint8_t> bytes;
    cv::imencode(".jpg", picture, bytes, {cv::IMWRITE_JPEG_QUALITY, 85});
    return "data:image/jpeg;base64," + base64(bytes);
}

json frames_json(const FrameSource& source, const std::vector<ShownFrame>& shown) {
    std::vector<std::size_t> wanted;
    json frames = json::array();
    for (const auto& [index, caption, axis] : shown) {
        wanted.push_back(index);
        frames.push_back({{"number", source.numbers()[index]},
                          {"caption", caption},
                          {"image", nullptr},
                          {"axis", axis}});
    }
    source.for_each(wanted, 1, [&frames](std::size_t k, const FrameImage& frame) {
        frames[k]["image"] = as_data_url(frame);
    });
    return frames;
}

json limit_json(const core::Interval& range, double unit = 1.0) {
    return {{"from", range.low / unit}, {"to", range.high / unit}, {"open", range.low_open}};
}

json limits_json() {
    return {{"fps", limit_json(TrackLimits::fps)},
            {"mm_per_px", limit_json(TrackLimits::mm_per_px)},
            {"length_mm", limit_json(StemLimits::length, 1e-3)},
            {"diameter_mm", limit_json(StemLimits::width, 1e-3)},
            {"density_kg_m3", limit_json(StemLimits::density)},
            {"exposure_ms", limit_json(StemLimits::frame_time_ms)},
            {"clamp", limit_json(TrackLimits::coordinates)},
            {"release_frame", limit_json(TrackLimits::frame_numbers)}};
}

json checks_json() {
    using Tolerances = TrackTolerances;
    return {{"length_note", Tolerances::noted_length},
            {"length_refusal", Tolerances::refused_length},
            {"pixels_of_length", Tolerances::length_pixels},
            {"width_smallest", Tolerances::smallest_width},
            {"width_largest", Tolerances::largest_width},
            {"width_pixels", Tolerances::width_pixels},
            {"cycles_per_frame_largest", Tolerances::cycles_per_frame},
            {"modulus_smallest", Tolerances::softest},
            {"modulus_largest", Tolerances::stiffest},
            // A chain of touching spheres has two thirds of the mass of the cylinder around it.
            {"mass_per_length_over_density_area", 2.0 / 3.0}};
}

/// If the frames last unequally long by the file's time stamps: their times, in those of the first,
/// and in `out` their first rate and a remark.
std::vector<double> unequal_times(const FrameSource& source, json& out) {
    std::vector<std::string> remarks;
    try {
        const FrameClock clock =
            frame_clock(source, first_frames(source.numbers().size()), TrackSettings(), remarks);
        if (remarks.empty())
            return {};
        out["proposed_fps"] = clock.frames_per_second;
        out["remarks"].push_back(remarks.front());
        return clock.times;
    } catch (const core::InputError&) {
        return {}; // frames of equal duration, whose rate a person must state
    }
}

} // namespace

json survey_video(const FrameSource& source, int threads) {
    FrameImage first;
    source.for_each(std::array<std::size_t, 1>{0}, 1,
                    [&first](std::size_t, const FrameImage& frame) { first = frame; });
    json out{{"frame_width", first.width},
             {"frame_height", first.height},
             {"bands", first.bands},
             {"frame_count", source.numbers().size()},
             {"first_number", source.numbers().front()},
             {"last_number", source.numbers().back()},
             {"stated_fps", nullptr},
             {"rate_is_the_cameras", source.states_camera_rate()},
             {"proposed_fps", nullptr},
             {"remarks", source.remarks()},
             {"detected", nullptr},
             {"remark", ""},
             {"frames", nullptr},
             {"limits", limits_json()},
             {"checks", checks_json()}};
    if (source.stated_fps())
        out["stated_fps"] = *source.stated_fps();
    const std::vector<double> times = unequal_times(source, out);
    std::vector<ShownFrame> shown;
    try {
        const auto [stem, width] = clearest_stem(source, threads);
        const std::vector<std::size_t> frames = frames_to_trace(source, stem, width, threads);
        Track track = traced(source, frames, stem, width, threads);
        for (std::size_t k = 0; k < frames.size() && !times.empty(); ++k)
            track.rows.times[k] = times[frames[k]];
        const std::string remark = find_motion(track);
        out["remark"] = remark;
        out["detected"] = stem_json(track, remark.empty());
        for (const auto& [position, caption] : shown_positions(track, remark.empty()))
            shown.push_back({frames[position], caption, axis_json(track, position)});
    } catch (const core::InputError& error) {
        out["remark"] = fmt::format("The stem was not found: {}", error.what());
        for (const std::size_t index : evenly_spaced(first_frames(source.numbers().size()), 16))
            shown.push_back({index, "", json::array()});
    }
    out["frames"] = frames_json(source, shown);
    return out;
}

} // namespace culm::measure
