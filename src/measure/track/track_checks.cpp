// SPDX-License-Identifier: BSD-3-Clause
#include "core/error.hpp"
#include "core/order_statistics.hpp"
#include "measure/track/track.hpp"

#include <cmath>
#include <optional>

#include <fmt/core.h>

namespace culm::measure {
namespace {

void doubt_missing_frames(Track& track) {
    const std::vector<int>& numbers = track.rows.numbers;
    int missing = 0;
    std::string places;
    for (std::size_t k = 1; k < numbers.size(); ++k) {
        const int gap = numbers[k] - numbers[k - 1] - 1;
        if (gap > 0 && (missing += gap) && places.size() < 60)
            places += fmt::format("{}{}", places.empty() ? "" : ", ", numbers[k - 1]);
    }
    if (missing > 0)
        track.remarks.push_back(fmt::format(
            "{} frame{} missing, after {}; the times of the others take that into account", missing,
            missing == 1 ? " is" : "s are", places));
}

/// Refuses a scale, clamp or length with which the stem is seen above its own tip.
void require_heights_on_stem(const Track& track) {
    const double highest = track.measurement.heights.back();
    if (const double length = track.measurement.stem.length; highest > length)
        throw core::InputError(fmt::format(
            "{}: with mm_per_px = {:g} the stem is seen up to {:.1f} mm above the clamp, but "
            "stem.length_mm is {:.1f}: is the scale, the clamp's row or the length wrong?",
            track.settings.file.string(), track.settings.metres_per_pixel * 1e3, highest * 1e3,
            length * 1e3));
}

void doubt_scale(Track& track) {
    const StemSurvey& survey = track.survey;
    const double expected = survey.trace.stem_width;
    using Tolerances = TrackTolerances;
    const double blur = Tolerances::width_pixels;
    if (survey.apparent_width > Tolerances::largest_width * expected + blur ||
        survey.apparent_width < Tolerances::smallest_width * expected - blur)
        track.remarks.push_back(fmt::format(
            "the stem appears {:.1f} pixels wide, its width over mm_per_px gives {:.1f}: is the "
            "scale or the diameter wrong?",
            survey.apparent_width, expected));
    const auto tip = tip_row(track);
    if (!tip || *tip <= 3.0)
        return;
    const double scale = track.settings.metres_per_pixel;
    const double length = (survey.clamp_row - *tip) * scale;
    const double stated = track.measurement.stem.length;
    const double off = std::abs(length - stated) - TrackTolerances::length_pixels * scale;
    if (off <= TrackTolerances::noted_length * stated)
        return;
    const std::string what =
        fmt::format("{:.1f} mm of the stem are seen above the clamp, stem.length_mm says {:.1f}: "
                    "is the scale, the clamp's row or the length wrong?",
                    length * 1e3, stated * 1e3);
    // Heights count from the clamp where the stem seems to begin, which is wrong if much is hidden.
    if (!track.settings.clamp && off > TrackTolerances::refused_length * stated)
        throw core::InputError(fmt::format(
            "{}: {} Say where the clamp is (up, and clamp_row or clamp_column) if the stem is "
            "partly hidden",
            track.settings.file.string(), what));
    track.remarks.push_back(what);
}

void doubt_rate(Track& track) {
    const double cycles = track.window.cycles_per_frame();
    if (cycles > TrackTolerances::cycles_per_frame)
        track.remarks.push_back(fmt::format(
            "only {:.1f} frames per swing: decay and higher modes are poorly resolved; below two "
            "frames per swing the frequency is aliased",
            1.0 / cycles));
    const double modulus = modulus_of_swing(track);
    if (track.measurement.stem.added_masses.empty() &&
        (modulus < TrackTolerances::softest || modulus > TrackTolerances::stiffest))
        track.remarks.push_back(fmt::format(
            "the swing at {:.4g} Hz corresponds to E = {:.3g} GPa for a plain beam, outside the "
            "range of plant stems: check fps, mm_per_px, length, diameter and density",
            cycles * track.frames_per_second, modulus * 1e-9));
}

void doubt_places(Track& track) {
    const TrackSettings& settings = track.settings;
    const RingDownWindow& window = track.window;
    if (settings.pull_sign && *settings.pull_sign != window.sign())
        track.remarks.emplace_back("the stem is pulled to the other side than pull_side says: "
                                   "deflections begin negative");
    if (!settings.axis)
        return;
    // Heights with a rest position, lowest first: a stem may be crooked further up.
    for (std::size_t h = 0; h < window.rest.size(); ++h)
        if (!std::isnan(window.rest[h])) {
            const double off = window.rest[h] - track.survey.trace.axis_column;
            if (std::abs(off) > 2.0 + 0.25 * track.survey.trace.stem_width)
                track.remarks.push_back(fmt::format(
                    "at rest the stem is {:.1f} pixels away from the stated axis just above the "
                    "clamp; deflections count from where it rests",
                    off));
            return;
        }
}

} // namespace

std::optional<double> tip_row(const Track& track) {
    for (std::size_t r = 0; r < track.rows.places.size(); ++r)
        if (track.rows.seen(r) > 0.25)
            return track.rows.places[r];
    return std::nullopt;
}

double modulus_of_swing(const Track& track) {
    const double frequency = track.window.cycles_per_frame() * track.frames_per_second;
    return std::pow(frequency / beam_frequency(track.measurement.stem, 1.0), 2);
}

void add_doubts(Track& track) {
    require_heights_on_stem(track);
    for (const std::string& remark : track.survey.remarks)
        track.remarks.push_back(remark);
    doubt_missing_frames(track);
    for (const std::string& remark : track.window.remarks)
        track.remarks.push_back(remark);
    doubt_scale(track);
    doubt_rate(track);
    doubt_places(track);
    if (!track.window.is_rest_seen)
        track.remarks.emplace_back(
            "the recording ends before the stem is at rest: the rest position "
            "is the centre of the decaying swing");
}

} // namespace culm::measure
