// SPDX-License-Identifier: BSD-3-Clause
#include "measure/folder/measurement_files.hpp"
#include "measure/track/frames/frame_from_opencv.hpp"
#include "measure/track/setup/video_survey.hpp"
#include "measure/track/track_report.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <boost/archive/iterators/base64_from_binary.hpp>
#include <boost/archive/iterators/transform_width.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace culm::measure {
namespace {

using json = nlohmann::ordered_json;

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

/// A hundredth of a pixel is more than a person can place.
double rounded(double pixels) {
    return std::round(pixels * 100.0) / 100.0;
}

json point_json(const PixelPoint& point) {
    return json::array({rounded(point.column), rounded(point.row)});
}

json stem_json(const DetectedStem& stem) {
    json out{{"up", up_name(stem.view.up)},
             {"clamp", point_json(stem.clamp)},
             {"tip", point_json(stem.tip)},
             {"channel", channel_name(stem.view.band)},
             {"stem", stem.view.sign > 0 ? "bright" : "dark"},
             {"width_px", rounded(stem.width)},
             {"release_frame", nullptr},
             {"pull_side", nullptr},
             {"pull_px", nullptr},
             {"cycles_per_frame", nullptr}};
    if (stem.release_frame) {
        out["release_frame"] = *stem.release_frame;
        out["pull_side"] = stem.pull_side;
        out["pull_px"] = rounded(stem.pull);
        out["cycles_per_frame"] = stem.cycles_per_frame;
    }
    return out;
}

json frames_json(const FrameSource& source, const VideoSurvey& survey) {
    std::vector<std::size_t> wanted;
    for (const ShownFrame& shown : survey.frames)
        wanted.push_back(shown.index);
    std::vector<std::string> images(wanted.size());
    source.for_each(wanted, 1, [&images](std::size_t k, const FrameImage& frame) {
        images[k] = as_data_url(frame);
    });
    json frames = json::array();
    for (std::size_t k = 0; k < survey.frames.size(); ++k) {
        const ShownFrame& shown = survey.frames[k];
        json axis = json::array();
        // Every third row is enough for a drawing.
        for (std::size_t i = 0; i < shown.axis.size(); i += 3)
            axis.push_back(point_json(shown.axis[i]));
        frames.push_back({{"number", shown.number},
                          {"caption", shown.caption},
                          {"image", images[k]},
                          {"axis", std::move(axis)}});
    }
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

} // namespace

json to_json(const FrameSource& source, const VideoSurvey& survey) {
    json data{{"frame_width", survey.width},
              {"frame_height", survey.height},
              {"bands", survey.bands},
              {"frame_count", source.numbers().size()},
              {"first_number", source.numbers().front()},
              {"last_number", source.numbers().back()},
              {"stated_fps", nullptr},
              {"rate_is_the_cameras", source.states_camera_rate()},
              {"detected", nullptr},
              {"remark", survey.remark},
              {"frames", frames_json(source, survey)},
              {"limits", limits_json()},
              {"checks", checks_json()}};
    if (source.stated_fps())
        data["stated_fps"] = *source.stated_fps();
    if (survey.stem)
        data["detected"] = stem_json(*survey.stem);
    return data;
}

} // namespace culm::measure
