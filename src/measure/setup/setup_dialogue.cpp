// SPDX-License-Identifier: BSD-3-Clause
#include "measure/setup/setup_dialogue.hpp"

#include "core/error.hpp"
#include "core/nearest_name.hpp"
#include "measure/folder/measurement_files.hpp"
#include "measure/track/track_report.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::measure {
namespace {

const std::vector<std::string> up_words{"decreasing_row", "increasing_row", "decreasing_column",
                                        "increasing_column"};

/// A number with six digits, always as a decimal fraction.
std::string toml_number(double value) {
    std::string text = fmt::format("{:.6g}", value);
    if (text.find_first_of(".en") == std::string::npos)
        text += ".0";
    return text;
}

/// Asks until an answer is allowed.
class Dialogue {
  public:
    explicit Dialogue(const Ask& ask) : ask_(ask) {}

    /// `check` returns the fault of an answer, empty if there is none.
    std::string text(const std::string& key, const std::string& fallback,
                     const std::function<std::string(const std::string&)>& check) const {
        std::string fault;
        while (true) {
            const std::optional<std::string> answer = ask_(fmt::format(
                "{}{}{}: ", fault, key, fallback.empty() ? "" : fmt::format(" [{}]", fallback)));
            if (!answer)
                throw core::InputError(fmt::format("the answers end at {}; nothing was written",
                                                   key.substr(0, key.find(' '))));
            const std::string& value = answer->empty() ? fallback : *answer;
            if (fault = check(value); fault.empty())
                return value;
            fault = fmt::format("  {}\n", fault);
        }
    }
    double number(const std::string& key, std::optional<double> fallback,
                  const core::Interval& range, double unit = 1.0) const {
        double value = 0.0;
        const core::Interval allowed{range.low / unit, range.high / unit, range.low_open,
                                     range.high_open};
        text(key, fallback ? fmt::format("{:.6g}", *fallback) : "", [&](const std::string& answer) {
            const char* end = answer.data() + answer.size();
            const auto [rest, error] = std::from_chars(answer.data(), end, value);
            return error == std::errc() && rest == end && allowed.contains(value)
                       ? std::string()
                       : fmt::format("must be a number in {}", allowed.text());
        });
        return value;
    }
    std::string word(const std::string& key, const std::string& fallback,
                     const std::vector<std::string>& words) const {
        return text(key, fallback, [&words](const std::string& answer) {
            if (std::ranges::find(words, answer) != words.end())
                return std::string();
            const std::string nearest = core::nearest_name(answer, words);
            return fmt::format("must be {}{}", fmt::join(words, ", "),
                               nearest.empty() ? "" : fmt::format(" (did you mean {}?)", nearest));
        });
    }

  private:
    const Ask& ask_;
};

std::string id_fault(const std::string& id) {
    const auto is_allowed = [](char letter) {
        return std::isalnum(static_cast<unsigned char>(letter)) != 0 ||
               std::string_view("._-").find(letter) != std::string_view::npos;
    };
    return !id.empty() && std::ranges::all_of(id, is_allowed)
               ? std::string()
               : "must consist of letters, digits and . _ -";
}

/// The name of the folder as an id.
std::string proposed_id(const std::filesystem::path& folder) {
    const std::string id = folder.lexically_normal().filename().string();
    return id_fault(id).empty() ? id : "stem";
}

/// Frames per second of the camera: those of its header, or those that the user states.
std::string rate_line(const Dialogue& dialogue, const FrameSource& source) {
    if (source.states_camera_rate())
        return {};
    const std::string note =
        source.stated_fps() ? fmt::format(" (not that of playback, {:.6g})", *source.stated_fps())
                            : "";
    return fmt::format("fps = {}\n", toml_number(dialogue.number("fps of the camera" + note,
                                                                 std::nullopt, TrackLimits::fps)));
}

/// Length of the stem along its direction in the picture, pixels.
double visible_length(const DetectedStem& stem) {
    return is_sideways(stem.view.up) ? std::abs(stem.clamp.column - stem.tip.column)
                                     : std::abs(stem.clamp.row - stem.tip.row);
}

} // namespace

std::string survey_text(const FrameSource& source, const VideoSurvey& survey) {
    std::string text = fmt::format("{}: {} frames of {} x {} pixels\n", source.name(),
                                   source.numbers().size(), survey.width, survey.height);
    if (const auto& stem = survey.stem) {
        text += fmt::format("    stem     {}, {:.1f} pixels wide, {:.0f} pixels long\n",
                            stem->view.sign > 0 ? "bright" : "dark", stem->width,
                            visible_length(*stem));
        text += fmt::format("    clamp    row {:.1f}, column {:.1f}; the tip is in the direction "
                            "{}\n",
                            stem->clamp.row, stem->clamp.column, up_name(stem->view.up));
        if (stem->release_frame)
            text += fmt::format("    release  after frame {}, pulled to the {} by {:.1f} pixels; "
                                "{:.1f} frames per swing\n",
                                *stem->release_frame, stem->pull_side, stem->pull,
                                1.0 / stem->cycles_per_frame);
    }
    return text + (survey.remark.empty() ? "" : fmt::format("    note: {}\n", survey.remark));
}

std::string ask_for_settings(const Ask& ask, const SetupRecording& recording,
                             const FrameSource& source, const VideoSurvey& survey) {
    const Dialogue dialogue(ask);
    const std::string id = dialogue.text("id of the stem", proposed_id(recording.folder), id_fault);
    const double length = dialogue.number("length_mm from the clamp to the tip", std::nullopt,
                                          StemLimits::length, 1e-3);
    const double diameter = dialogue.number("diameter_mm", std::nullopt, StemLimits::width, 1e-3);
    const double density = dialogue.number("density_kg_m3 of the chain of touching spheres",
                                           std::nullopt, StemLimits::density);
    std::string video = fmt::format("[video]\nframes = {}\n", quoted(recording.frames));
    video += rate_line(dialogue, source);
    const auto& stem = survey.stem;
    std::optional<double> scale;
    if (stem && visible_length(*stem) > 0.0)
        scale = length / visible_length(*stem);
    video +=
        fmt::format("mm_per_px = {}\n",
                    toml_number(dialogue.number(
                        scale ? "mm_per_px (proposed: length over visible length)" : "mm_per_px",
                        scale, TrackLimits::mm_per_px)));
    const std::string up = dialogue.word("up, from the clamp to the tip",
                                         stem ? up_name(stem->view.up) : "", up_words);
    const bool sideways = up.ends_with("column");
    const std::string clamp = sideways ? "clamp_column" : "clamp_row";
    std::optional<double> place;
    if (stem && sideways == is_sideways(stem->view.up))
        place = sideways ? stem->clamp.column : stem->clamp.row;
    video += fmt::format("up = {}\n{} = {}\n", quoted(up), clamp,
                         toml_number(dialogue.number(clamp, place, TrackLimits::coordinates)));
    if (stem)
        video += fmt::format("stem = \"{}\"\n", stem->view.sign > 0 ? "bright" : "dark");
    return fmt::format("# written with `culm setup --text`, {}\n{}\n[stem]\nid = {}\nlength_mm = "
                       "{}\ndiameter_mm = {}\ndensity_kg_m3 = {}\n",
                       recording.program, video, quoted(id), toml_number(length),
                       toml_number(diameter), toml_number(density));
}

} // namespace culm::measure
