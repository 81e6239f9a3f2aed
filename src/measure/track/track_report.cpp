// SPDX-License-Identifier: BSD-3-Clause
#include "measure/track/track_report.hpp"

#include "core/user_files.hpp"
#include "measure/folder/measurement_folder.hpp"
#include "measure/track/track.hpp"

#include <algorithm>
#include <array>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace culm::measure {
namespace {

constexpr std::array<const char*, 4> up_names{"decreasing_row", "increasing_row",
                                              "decreasing_column", "increasing_column"};
constexpr std::array<const char*, 3> channel_names{"red", "green", "blue"};

const char* band_name(const StemSurvey& survey) {
    return survey.bands == 1 ? "grey" : channel_name(survey.view.band);
}

/// Positions of the clamp and the axis in the terms of video.toml.
nlohmann::ordered_json places_json(const Track& track) {
    const StemSurvey& survey = track.survey;
    const PixelPoint point = in_frame({survey.trace.axis_column, survey.clamp_row},
                                      survey.frame_width, survey.frame_height, survey.view.up);
    nlohmann::ordered_json json;
    const bool sideways = is_sideways(survey.view.up);
    json["up"] = up_name(survey.view.up);
    json[sideways ? "clamp_column" : "clamp_row"] = sideways ? point.column : point.row;
    json[sideways ? "axis_row" : "axis_column"] = sideways ? point.row : point.column;
    json["clamp_detected"] = !track.settings.clamp;
    json["up_detected"] = !track.settings.up;
    json["pull_side"] = positive_side(track);
    json["best_channel"] = band_name(survey);
    json["stem"] = survey.view.sign > 0 ? "bright" : "dark";
    return json;
}

/// Number of the frame, with a fraction, at which the stem was let go.
double release_frame(const Track& track) {
    const AxisRecord& rows = track.rows;
    const std::size_t held = std::min(track.window.last_held, rows.times.size() - 2);
    const double share =
        (track.window.release.time - rows.times[held]) / (rows.times[held + 1] - rows.times[held]);
    return rows.numbers[held] + share * (rows.numbers[held + 1] - rows.numbers[held]);
}

double seen_fraction(const Measurement& measurement) {
    return double(known(measurement.deflections).size()) / double(measurement.deflections.size());
}

/// Values that video.toml does not state, with the key of [video] that states each.
std::string assumed_text(const Track& track) {
    const TrackSettings& settings = track.settings;
    const StemSurvey& survey = track.survey;
    const bool sideways = is_sideways(survey.view.up);
    std::string text;
    const auto add = [&text](const std::string& what, std::string_view key) {
        text += fmt::format("    {}  {}   ([video] {})\n", text.empty() ? "assumed:" : "        ",
                            what, key);
    };
    if (!settings.fps)
        add(fmt::format("{:g} frames/s, {}", track.frames_per_second, track.rate_source), "fps");
    if (!settings.up)
        add(fmt::format("the tip is toward {}", up_name(survey.view.up)), "up");
    if (!settings.clamp)
        add(fmt::format("the stem is clamped at {} {:.1f}", sideways ? "column" : "row",
                        places_json(track)[sideways ? "clamp_column" : "clamp_row"].get<double>()),
            sideways ? "clamp_column" : "clamp_row");
    if (!settings.stem_sign)
        add(fmt::format("the stem is {} than its background",
                        survey.view.sign > 0 ? "brighter" : "darker"),
            "stem");
    if (!settings.band && survey.bands > 1)
        add(fmt::format("the {} channel shows it best", band_name(survey)), "best_channel");
    if (!settings.pull_sign)
        add(fmt::format("deflections are positive toward the {}, where it was held",
                        positive_side(track)),
            "pull_side");
    if (!settings.release_frame)
        add(fmt::format("it was let go at frame {:.2f}", release_frame(track)), "release_frame");
    return text;
}

} // namespace

const char* up_name(Up up) {
    return up_names.at(static_cast<std::size_t>(up));
}

const char* channel_name(Band band) {
    return channel_names.at(static_cast<std::size_t>(band));
}

const char* positive_side(const Track& track) {
    const int sign = track.settings.pull_sign.value_or(track.window.sign());
    if (is_sideways(track.survey.view.up))
        return sign > 0 ? "bottom" : "top";
    return sign > 0 ? "right" : "left";
}

nlohmann::ordered_json to_json(const Track& track) {
    const StemSurvey& survey = track.survey;
    const RingDownWindow& window = track.window;
    const double scale_mm = track.settings.metres_per_pixel * 1e3;
    nlohmann::ordered_json json;
    json["stem"] = track.measurement.stem.id;
    json["source"] = track.settings.frames;
    json["fps"] = track.frames_per_second;
    json["fps_source"] = track.rate_source;
    json["mm_per_px"] = scale_mm;
    json["frame_size_px"] = {survey.frame_width, survey.frame_height};
    json["frames_tracked"] = track.rows.numbers.size();
    json["view"] = places_json(track);
    json["contrast"] = {{"stem", survey.contrast},
                        {"noise", survey.noise},
                        {"threshold_at_clamp", survey.trace.threshold_by_row.at(
                                                   std::size_t(survey.trace.bottom_row - 1))},
                        {"threshold", track.settings.threshold ? "given" : "automatic"}};
    json["apparent_width_px"] = survey.apparent_width;
    json["release"] = {{"last_held_frame", track.rows.numbers[window.last_held]},
                       {"frame", release_frame(track)},
                       {"held_frames", window.held_frames},
                       {"pull_mm", window.pull() * scale_mm},
                       {"pull_at_height_mm", track.measurement.heights[window.watched] * 1e3}};
    json["swing_hz"] = window.cycles_per_frame() * track.frames_per_second;
    json["modulus_of_bare_beam_pa"] = modulus_of_swing(track);
    json["rest"] = {{"from", window.is_rest_seen ? "frames at rest" : "decaying swing"},
                    {"first_frame", window.rest_begin ? nlohmann::ordered_json(
                                                            track.rows.numbers[*window.rest_begin])
                                                      : nlohmann::ordered_json(nullptr)}};
    json["kept_frames"] = {track.rows.numbers[track.first_kept],
                           track.rows.numbers[track.last_kept]};
    json["noise_source"] = window.noise_source;
    json["noise_correlation"] = window.noise_correlation
                                    ? nlohmann::ordered_json(*window.noise_correlation)
                                    : nlohmann::ordered_json(nullptr);
    json["heights"] = nlohmann::ordered_json::array();
    for (std::size_t h = 0; h < track.heights.places.size(); ++h)
        json["heights"].push_back(
            {{"height_mm", track.measurement.heights[h] * 1e3},
             {"rest_px", window.rest[h]},
             {"noise_mm", h < window.noise.size() ? window.noise[h] * scale_mm : std::nan("")},
             {"moving_noise_mm",
              h < window.moving_noise.size() ? window.moving_noise[h] * scale_mm : std::nan("")},
             {"seen", track.heights.seen(h)}});
    json["seen"] = seen_fraction(track.measurement);
    json["remarks"] = track.remarks;
    return json;
}

std::string summary_text(const Track& track) {
    const Measurement& measurement = track.measurement;
    const RingDownWindow& window = track.window;
    const auto& view = track.survey.view;
    const double scale_mm = track.settings.metres_per_pixel * 1e3;
    std::string text = fmt::format(
        "{}: {} frames at {:g} frames/s, {} x {} pixels, {:g} mm/px; {} stem in the {} band, tip "
        "toward {}\n",
        measurement.stem.id, track.rows.numbers.size(), track.frames_per_second,
        track.survey.frame_width, track.survey.frame_height, scale_mm,
        view.sign > 0 ? "bright" : "dark", band_name(track.survey), up_name(view.up));
    text += fmt::format(
        "    release  frame {:.2f}, pulled to the {} by {:.2f} mm at {:g} mm, held for {} "
        "frames\n",
        release_frame(track), positive_side(track), window.pull() * scale_mm,
        measurement.heights[window.watched] * 1e3, window.held_frames);
    text += fmt::format("    swing    {:.2f} Hz, {:.1f} frames per cycle; as a plain beam, E = "
                        "{:.3g} GPa\n    stem     {}\n",
                        window.cycles_per_frame() * track.frames_per_second, window.period(),
                        modulus_of_swing(track) * 1e-9,
                        stem_line(measurement.stem, modulus_of_swing(track)));
    text += fmt::format(
        "    rest     {}\n",
        window.rest_begin ? fmt::format("from frame {}", track.rows.numbers[*window.rest_begin])
                          : std::string("not reached; the centre of the decaying swing is taken"));
    text += fmt::format("    kept     {} times x {} heights ({:g} … {:g} mm), {:.1f} % seen\n",
                        measurement.times.size(), measurement.heights.size(),
                        measurement.heights.front() * 1e3, measurement.heights.back() * 1e3,
                        100.0 * seen_fraction(measurement));
    if (measurement.noise)
        text += fmt::format(
            "    noise    {:.4f} mm ({:.3f} px), from {}{}\n", *measurement.noise * 1e3,
            *measurement.noise * 1e3 / scale_mm, measurement.noise_source,
            window.noise_correlation
                ? fmt::format("; correlation from frame to frame {:.2g}", *window.noise_correlation)
                : "");
    for (const std::string& remark : track.remarks)
        text += fmt::format("    note: {}\n", remark);
    return text + assumed_text(track);
}

void write_track(const std::filesystem::path& folder, const Track& track, bool with_video) {
    write_measurement(folder, track.measurement);
    core::write_text(folder / "track.json", to_json(track).dump(2) + '\n');
    write_contact_sheet(folder / "contact_sheet.png", track);
    if (with_video)
        write_overlay_video(folder / "overlay.avi", track);
}

} // namespace culm::measure
