// SPDX-License-Identifier: BSD-3-Clause
#include "core/decimal_text.hpp"
#include "core/user_files.hpp"
#include "measure/folder/measurement_files.hpp"
#include "measure/track/track.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include <fmt/format.h>

namespace culm::measure {
namespace {

constexpr core::Interval pixels{1.0, 1e5};

std::optional<int> whole(const core::TomlTable& table, const std::string& key,
                         const core::Interval& range) {
    const auto value = table.whole_number(key, range);
    return value ? std::optional(static_cast<int>(*value)) : std::nullopt;
}

/// Index of the word, or nothing if it is absent, wrong, or "auto".
std::optional<std::size_t> choice(const core::TomlTable& table, const std::string& key,
                                  std::vector<std::string> words) {
    words.emplace_back("auto");
    const auto index = table.word(key, words);
    return index && *index + 1 < words.size() ? index : std::nullopt;
}

/// Row or column of the clamp and of the axis; the key determines the stem's orientation.
void read_place(const core::TomlTable& video, TrackSettings& settings) {
    if (const auto index = choice(video, "up", {up_names.begin(), up_names.end()}))
        settings.up = static_cast<Up>(*index);
    const auto clamp_row = video.number("clamp_row", TrackLimits::coordinates);
    const auto clamp_column = video.number("clamp_column", TrackLimits::coordinates);
    const auto axis_column = video.number("axis_column", TrackLimits::coordinates);
    const auto axis_row = video.number("axis_row", TrackLimits::coordinates);
    for (const auto& [key, is_for_sideways] :
         {std::pair{"clamp_row", false}, std::pair{"axis_column", false},
          std::pair{"clamp_column", true}, std::pair{"axis_row", true}})
        if (video.has(key) && !settings.up)
            video.fault(key, "also needs `up`, the direction from the clamp to the tip");
        else if (video.has(key) && is_sideways(*settings.up) != is_for_sideways)
            video.fault(key, is_for_sideways
                                 ? "belongs to a sideways stem (up = \"decreasing_column\" or "
                                   "\"increasing_column\")"
                                 : "belongs to an upright stem; of a sideways one give "
                                   "clamp_column and axis_row");
    settings.clamp = clamp_row ? clamp_row : clamp_column;
    settings.axis = axis_column ? axis_column : axis_row;

    if (const auto index = choice(video, "pull_side", {"left", "right", "top", "bottom"})) {
        settings.pull_sign = *index % 2 == 0 ? -1 : 1;
        const bool names_row = *index >= 2;
        if (settings.up && is_sideways(*settings.up) != names_row)
            video.fault("pull_side", names_row ? "an upright stem is pulled \"left\" or \"right\""
                                               : "a sideways stem is pulled to \"top\" or "
                                                 "\"bottom\"");
        if (!settings.up && names_row)
            video.fault("pull_side", "also needs `up`, the direction from the clamp to the "
                                     "tip");
    }
}

void read_appearance(const core::TomlTable& video, TrackSettings& settings) {
    if (const auto index = choice(video, "best_channel", {band_names.begin(), band_names.end()}))
        settings.band = static_cast<Band>(*index);
    if (const auto index = choice(video, "stem", {"bright", "dark"}))
        settings.stem_sign = *index == 0 ? 1 : -1;
    settings.threshold = video.number("threshold", {0.0, 255.0, true});
}

void read_frames(const core::TomlTable& video, TrackSettings& settings) {
    settings.frames = video.text("frames").value_or("");
    if (const std::string fault = core::named_path_fault(settings.frames);
        !fault.empty() && video.is_text("frames"))
        video.fault("frames", fault);
    video.missing("frames", "an image sequence like \"frames/%05d.png\", a video file, or a "
                            "Photron header (.cih)");
    settings.first_frame = whole(video, "first_frame", TrackLimits::frame_numbers);
    settings.frame_count = whole(video, "frame_count", {1.0, 1e9});
    settings.fps = video.number("fps", TrackLimits::fps);
    settings.metres_per_pixel =
        1e-3 * video.number("mm_per_px", TrackLimits::mm_per_px).value_or(0.0);
    video.missing("mm_per_px", "the picture's scale at the stem");
    settings.width = whole(video, "width_px", pixels);
    settings.height = whole(video, "height_px", pixels);
    for (const double number : video.numbers("missing_frames", TrackLimits::frame_numbers))
        settings.missing_frames.push_back(static_cast<int>(std::lround(number)));
}

void read_output(const core::TomlTable& video, TrackSettings& settings) {
    for (const double height : video.numbers("heights_mm", {0.0, 1e5, true}))
        settings.heights.push_back(core::with_point_moved(height, -3));
    if (std::ranges::adjacent_find(settings.heights, std::greater_equal{}) !=
        settings.heights.end())
        video.fault("heights_mm", "does not ascend");
    if (settings.heights.size() > most_heights)
        video.fault("heights_mm", fmt::format("{} heights; at most {} are allowed",
                                              settings.heights.size(), most_heights));
    settings.height_step = video.quantity("height_step_mm", {0.0, 100.0, true});
    if (settings.height_step && *settings.height_step < settings.metres_per_pixel)
        video.fault(video.spelling_of("height_step_mm"),
                    fmt::format("must be at least mm_per_px = {}, the distance of two image rows",
                                core::decimal_text(settings.metres_per_pixel, 3)));
    if (!settings.heights.empty() && settings.height_step)
        video.fault(video.spelling_of("height_step_mm"),
                    "is given in addition to heights_mm: one of them is enough");
    if (const auto rows = whole(video, "rows_per_height", {1.0, 51.0}))
        settings.rows_per_height = *rows;
    if (settings.rows_per_height % 2 == 0)
        video.fault("rows_per_height", "must be odd: as many rows above as below");
    settings.release_frame = whole(video, "release_frame", TrackLimits::frame_numbers);
    settings.frames_before_release =
        whole(video, "frames_before_release", TrackLimits::frame_numbers);
    const std::array<std::string, 2> ends{"rest", "end"};
    if (const auto index = video.word("until", ends))
        settings.trim_after_rest = *index == 0;
}

} // namespace

TrackSettings read_track_settings(const std::filesystem::path& file) {
    core::TomlDocument document(file);
    const core::TomlTable& root = document.root();
    TrackSettings settings;
    settings.file = file;
    const core::TomlTable video = root.table("video");
    root.missing("video", "write a table [video] with frames, fps, mm_per_px");
    read_frames(video, settings);
    read_place(video, settings);
    read_appearance(video, settings);
    read_output(video, settings);
    read_stem_tables(root, settings.description);
    const double length = settings.description.stem.length;
    if (!settings.heights.empty() && length > 0.0 && std::ranges::max(settings.heights) > length)
        video.fault("heights_mm",
                    fmt::format("{:g} mm lies above the stem, which is {:g} mm long",
                                std::ranges::max(settings.heights) * 1e3, length * 1e3));
    // Two values for one number would be ambiguous.
    if (settings.fps && settings.description.frames_per_second)
        root.fault("camera", "fps is already given in [video]");
    else if (settings.description.frames_per_second)
        settings.fps = settings.description.frames_per_second;
    if (settings.description.reading == Reading::Material)
        root.table("measurement")
            .fault("reading", "a tracked video is read in rows: write \"row\" or nothing");
    for (const core::TomlTable& sensor : root.tables("sensor"))
        sensor.fault("column", "a video has only rows of the picture: describe a sensor in the "
                               "stem.toml of its own measurement, its mass here as [[added_mass]]");
    document.finish();
    return settings;
}

} // namespace culm::measure
