// SPDX-License-Identifier: BSD-3-Clause
#include "measure/track/track_report.hpp"

#include "core/describe.hpp"
#include "core/user_files.hpp"
#include "measure/folder/measurement_folder.hpp"
#include "measure/track/track.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <ranges>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace culm::measure {
namespace {

const char* band_name(const StemSurvey& survey) {
    return survey.bands == 1 ? "grey" : to_string(survey.view.band);
}

/// The clamp and the axis in the terms of video.toml.
PixelPoint place_in_frame(const Track& track) {
    const StemSurvey& survey = track.survey;
    return in_frame({survey.trace.axis_column, survey.clamp_row}, survey.frame_width,
                    survey.frame_height, survey.view.up);
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
        add(fmt::format("the tip is toward {}", to_string(survey.view.up)), "up");
    if (!settings.clamp)
        add(fmt::format("the stem is clamped at {} {:.1f}", sideways ? "column" : "row",
                        sideways ? place_in_frame(track).column : place_in_frame(track).row),
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

/// Clamp and axis in the terms of video.toml.
template <class To>
void describe_place(To& to, const Track& track) {
    const bool is_on_its_side = is_sideways(track.survey.view.up);
    const auto point = [&] { return place_in_frame(track); };
    to("up", [&] { return to_string(track.survey.view.up); });
    to.when(is_on_its_side, [&] {
        to("clamp_column", [&] { return point().column; });
        to("axis_row", [&] { return point().row; });
    });
    to.when(!is_on_its_side, [&] {
        to("clamp_row", [&] { return point().row; });
        to("axis_column", [&] { return point().column; });
    });
    to("clamp_detected", [&] { return !track.settings.clamp; });
    to("up_detected", [&] { return !track.settings.up; });
    to("pull_side", [&] { return positive_side(track); });
    to("best_channel", [&] { return band_name(track.survey); });
    to("stem", [&] { return track.survey.view.sign > 0 ? "bright" : "dark"; });
}

template <class To>
void describe_window(To& to, const Track& track) {
    const RingDownWindow& window = track.window;
    const double scale = track.settings.metres_per_pixel;
    to.object("release", [&] {
        to("last_held_frame", [&] { return track.rows.numbers[window.last_held]; });
        to("frame", [&] { return release_frame(track); });
        to("held_frames", window.held_frames);
        to("pull_mm", [&] { return window.pull() * scale; });
        to("pull_at_height_mm", [&] { return track.measurement.heights[window.watched]; });
    });
    to("swing_hz", [&] { return window.cycles_per_frame() * track.frames_per_second; });
    to("modulus_of_bare_beam_pa", [&] { return modulus_of_swing(track); });
    to.object("rest", [&] {
        to("from", [&] { return window.is_rest_seen ? "frames at rest" : "decaying swing"; });
        to("first_frame", [&] {
            return window.rest_begin ? std::optional(track.rows.numbers[*window.rest_begin])
                                     : std::nullopt;
        });
    });
    to("kept_frames", [&] {
        return std::vector{track.rows.numbers[track.first_kept],
                           track.rows.numbers[track.last_kept]};
    });
    to("noise_source", window.noise_source);
    const auto noise_at = [&](const std::vector<double>& noise, std::size_t h) {
        return h < noise.size() ? noise[h] * scale : std::nan("");
    };
    const auto heights = [&] {
        return std::views::iota(std::size_t{0}, track.heights.places.size());
    };
    to.list("heights", heights, [&](std::size_t h) {
        to("height_mm", [&] { return track.measurement.heights[h]; });
        to("rest_px", [&] { return window.rest[h]; });
        to("noise_mm", [&] { return noise_at(window.noise, h); });
        to("moving_noise_mm", [&] { return noise_at(window.moving_noise, h); });
        to(
            "seen", [&] { return track.heights.seen(h); }, "share of the frames");
    });
}

} // namespace

/// track.json.
template <class To>
void describe(To& to, const Track& track) {
    const StemSurvey& survey = track.survey;
    to("stem", track.measurement.stem.id);
    to("source", track.settings.frames);
    to("fps", track.frames_per_second);
    to("fps_source", track.rate_source);
    to("mm_per_px", [&] { return 1e3 * track.settings.metres_per_pixel; });
    to("frame_size_px", [&] { return std::vector{survey.frame_width, survey.frame_height}; });
    to("frames_tracked", [&] { return track.rows.numbers.size(); });
    to.object("view", [&] { describe_place(to, track); });
    to.object("contrast", [&] {
        to("stem", survey.contrast);
        to("noise", survey.noise);
        to("threshold_at_clamp", [&] {
            return survey.trace.threshold_by_row.at(
                static_cast<std::size_t>(survey.trace.bottom_row - 1));
        });
        to("threshold", [&] { return track.settings.threshold ? "given" : "automatic"; });
    });
    to("apparent_width_px", survey.apparent_width);
    describe_window(to, track);
    to("seen", [&] { return seen_fraction(track.measurement); });
    to("remarks", track.remarks);
}

const char* positive_side(const Track& track) {
    const int sign = track.settings.pull_sign.value_or(track.window.sign());
    if (is_sideways(track.survey.view.up))
        return sign > 0 ? "bottom" : "top";
    return sign > 0 ? "right" : "left";
}

nlohmann::json track_json(const Track& track) {
    return core::json_of(track);
}

nlohmann::json track_schema() {
    return core::schema_of<Track>();
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
        view.sign > 0 ? "bright" : "dark", band_name(track.survey), to_string(view.up));
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
        text +=
            fmt::format("    noise    {:.4f} mm ({:.3f} px), from {}\n", *measurement.noise * 1e3,
                        *measurement.noise * 1e3 / scale_mm, measurement.noise_source);
    for (const std::string& remark : track.remarks)
        text += fmt::format("    note: {}\n", remark);
    return text + assumed_text(track);
}

void write_track(const std::filesystem::path& folder, const Track& track) {
    write_measurement(folder, track.measurement);
    core::write_text(folder / "track.json", track_json(track).dump(2) + '\n');
    write_contact_sheet(folder / "contact_sheet.png", track);
}

} // namespace culm::measure
