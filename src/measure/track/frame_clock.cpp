// SPDX-License-Identifier: BSD-3-Clause
// When each frame was taken: by its number and the camera's rate, or by the file's time stamps.
#include "core/error.hpp"
#include "measure/track/track.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>

namespace culm::measure {
namespace {

/// Frame numbers as the camera would have counted them: frames that the settings declare missing
/// shift all later ones.
std::vector<int> true_numbers(const FrameSource& source, std::span<const std::size_t> wanted,
                              const TrackSettings& settings) {
    std::vector<int> numbers;
    std::vector<int> missing = settings.missing_frames;
    std::ranges::sort(missing);
    // Both lists ascend, so what lies before one frame lies before the next as well.
    std::size_t before = 0;
    for (const std::size_t index : wanted) {
        const int number = source.numbers()[index];
        while (before < missing.size() && missing[before] <= number + int(before))
            ++before;
        numbers.push_back(number + int(before));
    }
    return numbers;
}

/// Frames over which a duration is averaged: stamps are rounded, often to a millisecond.
constexpr std::size_t part = 20;

/// Mean duration, ms, of the `part` frames from each wanted frame on; empty without stamps.
std::vector<double> durations(const FrameSource& source, std::span<const std::size_t> wanted) {
    std::vector<double> found;
    if (source.stamps().empty())
        return found;
    for (std::size_t k = 0; k + part < wanted.size(); ++k)
        found.push_back((source.stamps()[wanted[k + part]] - source.stamps()[wanted[k]]) /
                        double(source.numbers()[wanted[k + part]] - source.numbers()[wanted[k]]));
    return found;
}

bool are_equal(double duration, double other) {
    return std::abs(duration - other) <= 0.03 * other + 0.1;
}

/// The camera's frames per second, from video.toml or from a recording that states it. A different
/// rate of a video file is interpreted as that of playback and causes a remark.
void state_rate(FrameClock& clock, const FrameSource& source, const TrackSettings& settings,
                std::vector<std::string>& remarks) {
    const std::optional<double> stated = source.stated_fps();
    if (!settings.fps) {
        if (!stated || !source.states_camera_rate())
            throw core::InputError(fmt::format(
                "{}: video.fps is missing: the camera's frames per second{}",
                settings.file.string(),
                stated ? fmt::format(" (the {:.6g} that the file states may be those of playback)",
                                     *stated)
                       : ""));
        clock.frames_per_second = *stated;
        clock.rate_source = "of the recording's header";
        return;
    }
    clock.frames_per_second = *settings.fps;
    clock.rate_source = "of video.toml";
    if (!stated || std::abs(*stated / *settings.fps - 1.0) <= 1e-3)
        return;
    if (source.states_camera_rate())
        throw core::InputError(
            fmt::format("{}: video.fps = {:g}: the camera's own header says {:g} frames/s for {}",
                        settings.file.string(), *settings.fps, *stated, source.name()));
    remarks.push_back(fmt::format(
        "the video file states {:.6g} frames/s, video.toml {:.6g}: the former is taken for the "
        "speed of playback; if it is the camera's, all times are wrong by that ratio",
        *stated, *settings.fps));
}

/// Times by the stamps of a file whose frames last unequally long: a telephone lengthens them when
/// the light fades. `lasting`: durations().
void take_stamps(FrameClock& clock, const FrameSource& source, std::span<const std::size_t> wanted,
                 const std::vector<double>& lasting, const TrackSettings& settings,
                 std::vector<std::string>& remarks) {
    const std::vector<double>& stamps = source.stamps();
    const double first = lasting.front();
    clock.frames_per_second = settings.fps.value_or(1e3 / first);
    clock.rate_source = "of the file's time stamps";
    const double frame = 1e3 / clock.frames_per_second; // ms
    // A rate that some frames have, or all on average, shows that the stamps are the camera's
    // times.
    const bool is_real_time =
        std::ranges::any_of(lasting, [&](double value) { return are_equal(value, frame); }) ||
        are_equal(1e3 / source.stated_fps().value_or(1e-3), frame);
    for (std::size_t k = 0; k < wanted.size(); ++k)
        clock.times[k] = clock.numbers.front() + (stamps[wanted[k]] - stamps[wanted.front()]) /
                                                     (is_real_time ? frame : first);
    const auto other = std::size_t(
        std::ranges::find_if(lasting, [&](double value) { return !are_equal(value, first); }) -
        lasting.begin());
    // The window that shows other durations first ends with a few such frames.
    std::size_t change = other + part;
    while (change > other && !are_equal(stamps[wanted[change]] - stamps[wanted[change - 1]], first))
        --change;
    remarks.push_back(fmt::format(
        "the frames last unequally long by the file's time stamps ({:.4g} ms, and {:.4g} ms from "
        "frame {} on): each reading has the time of its frame",
        first, lasting[std::min(other + part, lasting.size() - 1)], clock.numbers[change]));
    if (!is_real_time)
        remarks.push_back(fmt::format(
            "video.fps = {:g}, but the first frames last {:.4g} ms in the file: the file is taken "
            "for slow motion, and its times are divided by {:.4g}",
            clock.frames_per_second, first, first / frame));
}

} // namespace

FrameClock frame_clock(const FrameSource& source, std::span<const std::size_t> wanted,
                       const TrackSettings& settings, std::vector<std::string>& remarks) {
    FrameClock clock;
    clock.numbers = true_numbers(source, wanted, settings);
    clock.times.assign(clock.numbers.begin(), clock.numbers.end());
    const std::vector<double> lasting = durations(source, wanted);
    if (std::ranges::all_of(lasting,
                            [&](double value) { return are_equal(value, lasting.front()); }))
        state_rate(clock, source, settings, remarks);
    else
        take_stamps(clock, source, wanted, lasting, settings, remarks);
    return clock;
}

} // namespace culm::measure
