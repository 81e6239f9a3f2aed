// SPDX-License-Identifier: BSD-3-Clause
#include "measure/track/track.hpp"

#include "core/error.hpp"
#include "core/order_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include <boost/container_hash/hash.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::measure {
namespace {

/// Indices of the frames that the settings request.
std::vector<std::size_t> wanted_frames(const FrameSource& source, const TrackSettings& settings) {
    const std::vector<int>& numbers = source.numbers();
    const int first = settings.first_frame.value_or(numbers.front());
    const long long last = settings.frame_count
                               ? static_cast<long long>(first) + *settings.frame_count - 1
                               : numbers.back();
    std::vector<std::size_t> wanted;
    for (std::size_t i = 0; i < numbers.size(); ++i)
        if (numbers[i] >= first && numbers[i] <= last)
            wanted.push_back(i);
    if (wanted.empty() || numbers[wanted.front()] != first || numbers[wanted.back()] != last)
        throw core::InputError(fmt::format(
            "{}: video.first_frame, video.frame_count ask for the frames {} to {}; {} has {} to {}",
            settings.file.string(), first, last, source.name(), numbers.front(), numbers.back()));
    if (wanted.size() < 12)
        throw core::InputError(fmt::format("{}: {} frames are too few; 12 at least are needed",
                                           source.name(), wanted.size()));
    return wanted;
}

/// A camera or converter replaces a lost frame by the previous one; while the stem swings, such a
/// frame contains no reading. A still picture without noise may legitimately repeat.
void drop_repeated_frames(Track& track, const std::vector<bool>& repeats) {
    const RingDownWindow& window = track.window;
    const std::size_t end = window.rest_begin.value_or(repeats.size());
    std::vector<int> dropped;
    for (std::size_t k = window.last_held + 1; k < end; ++k) {
        if (!repeats[k])
            continue;
        for (AxisRecord* record : {&track.rows, &track.heights})
            std::fill_n(record->columns.begin() + std::ptrdiff_t(k * record->places.size()),
                        record->places.size(), std::numeric_limits<double>::quiet_NaN());
        dropped.push_back(track.rows.numbers[k]);
    }
    if (!dropped.empty())
        track.remarks.push_back(fmt::format("frames that repeat the one before them pixel by pixel "
                                            "while the stem swings are left out: {}",
                                            fmt::join(dropped, ", ")));
}

std::vector<double> heights_in_pixels(const Track& track) {
    const double scale = track.settings.metres_per_pixel;
    std::vector<double> heights;
    for (const double height : track.settings.heights)
        heights.push_back(height / scale);
    std::ranges::sort(heights);
    if (heights.empty())
        heights = spaced_heights(track.rows, track.survey.clamp_row,
                                 track.settings.height_step.value_or(0.0) / scale, scale * 1e3);
    if (heights.empty())
        throw core::InputError(fmt::format(
            "{}: no row of the picture shows the stem in nine of ten frames (does it leave the "
            "picture, or is it hidden?); give heights_mm to track it all the same",
            track.source));
    return heights;
}

/// Removes heights at which the stem is hardly ever seen: their columns would be empty.
void drop_unseen_heights(Track& track) {
    constexpr double fewest = 12.0;
    const auto frames = double(track.rows.numbers.size());
    std::vector<double> kept;
    std::string dropped;
    for (std::size_t h = 0; h < track.heights.places.size(); ++h)
        if (const double height = track.heights.places[h]; track.heights.seen(h) * frames >= fewest)
            kept.push_back(height);
        else
            dropped += fmt::format("{}{:g}", dropped.empty() ? "" : ", ",
                                   height * track.settings.metres_per_pixel * 1e3);
    if (dropped.empty())
        return;
    if (kept.empty())
        throw core::InputError(
            fmt::format("{}: video.heights_mm: the stem is seen at none of these heights ({})",
                        track.settings.file.string(), dropped));
    track.remarks.push_back(
        fmt::format("heights at which the stem is not seen are left out: {} mm", dropped));
    set_heights(track, kept);
}

/// Writes the exposure determined from the fastest frames (in frames) into the description.
void state_exposure(Track& track, std::optional<double> frames) {
    if (!frames)
        return;
    const double exposure = *frames / track.frames_per_second;
    track.settings.description.exposure = std::round(exposure * 1e6) / 1e6;
    track.remarks.push_back(fmt::format(
        "the stem smears where it is fast, as with an exposure of {:.2g} ms; give exposure_ms in "
        "[camera] if it is known",
        exposure * 1e3));
}

/// Kept: a short time before the release, all until rest and as much again as a period.
void choose_frames(Track& track) {
    const RingDownWindow& window = track.window;
    const std::size_t before = std::size_t(track.settings.frames_before_release.value_or(
        int(std::min<std::size_t>(50, std::max<std::size_t>(1, window.held_frames)))));
    track.first_kept = window.last_held + 1 - std::min(window.last_held + 1, before);
    track.last_kept = track.rows.numbers.size() - 1;
    if (track.settings.trim_after_rest && window.rest_begin)
        track.last_kept = std::min(
            track.last_kept, *window.rest_begin + 2 * std::size_t(std::ceil(window.period())));
}

/// Millimetres with five decimals resolve a hundredth of a camera's resolution.
double rounded_length(double metres) {
    return std::round(metres * 1e8) / 1e8;
}

/// Shift of the edges by uneven light across the swing, equal in all frames, pixels, as measured on
/// rendered videos (docs/tracking.md).
constexpr double row_uncertainty_px = 0.02;

/// Standard uncertainty due to the position of an edge between two pixels and to the grain of the
/// stem, which change between frames while the stem moves, pixels; measured likewise.
constexpr double moving_uncertainty_px = 0.006;

/// Standard uncertainty of every reading: that of the edges' fit, scaled to agree with the scatter
/// of a still stem, combined with the part that only motion causes. Empty if the scatter is unknown
/// or an edge was found without a fit.
std::vector<double> reading_uncertainties(const Track& track) {
    constexpr double sharp = 0.25; // share of the frames with the sharpest edges, used as still
    const std::size_t places = track.heights.places.size();
    double seen = 0.0;
    double expected = 0.0;
    for (std::size_t h = 0; h < places; ++h) {
        std::vector<double> of_height;
        for (std::size_t at = h; at < track.heights.columns.size(); at += places)
            if (!std::isnan(track.heights.columns[at]))
                of_height.push_back(track.heights.uncertainties[at]);
        if (of_height.empty() || !(track.window.noise[h] > 0.0))
            continue;
        seen += std::pow(track.window.noise[h], 2);
        expected += std::pow(core::quantile(std::move(of_height), sharp), 2);
    }
    if (!(seen > 0.0))
        return {};
    const double factor = std::sqrt(seen / expected) * track.settings.metres_per_pixel;
    std::vector<double> out;
    for (std::size_t k = track.first_kept; k <= track.last_kept; ++k)
        for (std::size_t h = 0; h < places; ++h) {
            const double uncertainty =
                std::hypot(factor * track.heights.uncertainties[k * places + h],
                           moving_uncertainty_px * track.settings.metres_per_pixel);
            if (!(uncertainty > 0.0) && !std::isnan(track.heights.at(k, h)))
                return {};
            // Must not become 0 by the rounding of the file.
            out.push_back(std::max(1e-8, rounded_length(uncertainty)));
        }
    return out;
}

void fill_measurement(Track& track) {
    Measurement& measurement = track.measurement;
    const double scale = track.settings.metres_per_pixel;
    const RingDownWindow& window = track.window;
    const double sign = track.settings.pull_sign.value_or(window.sign());
    measurement = track.settings.description;
    measurement.remarks.clear();
    if (track.rows.is_even())
        measurement.frames_per_second = track.frames_per_second;
    if (!measurement.release_uncertainty && measurement.release != ReleaseKind::Moving)
        measurement.release_uncertainty = std::max(
            1e-9, std::round(1e9 * window.release.uncertainty / track.frames_per_second) * 1e-9);
    measurement.reading = Reading::Row;
    if (measurement.row_time)
        measurement.row_height = rounded_length(scale);
    for (const double height : track.heights.places)
        measurement.heights.push_back(rounded_length(height * scale));
    for (std::size_t k = track.first_kept; k <= track.last_kept; ++k) {
        const double time =
            (track.heights.times[k] - window.release.time) / track.frames_per_second;
        measurement.times.push_back(std::round(time * 1e9) / 1e9);
        for (std::size_t h = 0; h < track.heights.places.size(); ++h)
            measurement.deflections.push_back(
                rounded_length(sign * (track.heights.at(k, h) - window.rest[h]) * scale));
    }
    // Heights that were never seen at rest get the mean noise of the others.
    double squares = 0.0;
    double count = 0.0;
    for (const double noise : window.noise)
        if (noise > 0.0) { // false for NaN
            squares += noise * noise;
            count += 1.0;
        }
    if (count == 0.0)
        return;
    measurement.noise = rounded_length(std::sqrt(squares / count) * scale);
    for (const double noise : window.noise)
        measurement.noise_by_height.push_back(
            noise > 0.0 ? std::max(1e-8, rounded_length(noise * scale)) : *measurement.noise);
    measurement.noise_source = window.noise_source;
    measurement.reading_uncertainties = reading_uncertainties(track);
    if (!measurement.uncertainties.row)
        measurement.uncertainties.row = rounded_length(row_uncertainty_px * scale);
}

WindowOptions window_options(const Track& track) {
    const TrackSettings& settings = track.settings;
    WindowOptions options{
        track.source, settings.description.stem.length / settings.metres_per_pixel, std::nullopt};
    if (settings.release_frame) {
        const auto found = std::ranges::lower_bound(track.rows.numbers, *settings.release_frame);
        if (found == track.rows.numbers.end() || *found != *settings.release_frame)
            throw core::InputError(fmt::format("{}: video.release_frame = {}: no such frame",
                                               settings.file.string(), *settings.release_frame));
        options.release_frame = std::size_t(found - track.rows.numbers.begin());
    }
    return options;
}

} // namespace

void set_heights(Track& track, const std::vector<double>& heights) {
    track.heights =
        at_heights(track.rows, track.survey.clamp_row, heights, track.settings.rows_per_height);
}

std::vector<bool> track_rows(Track& track, const FrameSource& source, int threads) {
    const StemSurvey& survey = track.survey;
    const std::vector<std::size_t>& wanted = track.source_indices;
    const std::size_t row_count = survey.trace.threshold_by_row.size();
    track.rows.places.resize(row_count);
    std::iota(track.rows.places.begin(), track.rows.places.end(), 0.0);
    track.rows.columns.resize(wanted.size() * row_count);
    track.rows.uncertainties.assign(wanted.size() * row_count,
                                    std::numeric_limits<double>::quiet_NaN());
    std::vector<std::size_t> fingerprints(wanted.size()); // equal for equal pixels
    source.for_each(wanted, threads, [&](std::size_t i, const FrameImage& frame) {
        if (frame.width != survey.frame_width || frame.height != survey.frame_height ||
            frame.bands != survey.bands)
            throw core::InputError(fmt::format("{}: frame {} differs in size or colours from the "
                                               "others",
                                               source.name(), source.numbers()[wanted[i]]));
        const BandImage image = upright_band(frame, survey.view.band, survey.view.up);
        fingerprints[i] = boost::hash_range(image.values.begin(), image.values.end());
        const BandImage contrast = stem_contrast(image, survey.view.sign, survey.trace.stem_width);
        std::ranges::copy(axis_columns(contrast, trace_stem(contrast, survey.trace), survey.trace),
                          track.rows.columns.begin() + std::ptrdiff_t(i * row_count));
    });
    std::vector<bool> repeats(wanted.size(), false);
    for (std::size_t i = 1; i < wanted.size(); ++i)
        repeats[i] = fingerprints[i] == fingerprints[i - 1];
    return repeats;
}

Track track_video(const TrackSettings& settings, int threads) {
    Track track;
    track.settings = settings;
    track.remarks = settings.description.remarks;
    const auto source = open_frames(settings.file.parent_path(), settings.frames);
    track.source = source->name();
    std::ranges::copy(source->remarks(), std::back_inserter(track.remarks));
    track.source_indices = wanted_frames(*source, settings);
    FrameClock clock = frame_clock(*source, track.source_indices, settings, track.remarks);
    track.frames_per_second = clock.frames_per_second;
    track.rate_source = clock.rate_source;
    track.survey = survey_stem(*source, track.source_indices, settings, threads);
    track.rows.numbers = std::move(clock.numbers);
    track.rows.times = std::move(clock.times);
    const std::vector<bool> repeats = track_rows(track, *source, threads);
    set_heights(track, heights_in_pixels(track));
    drop_unseen_heights(track);
    // The second pass needs the time of the release, which the first one determines.
    track.window = find_ring_down(track.heights, window_options(track));
    state_exposure(track, match_rows(track, *source, threads));
    set_heights(track, track.heights.places);
    track.window = find_ring_down(track.heights, window_options(track));
    drop_repeated_frames(track, repeats);
    choose_frames(track);
    fill_measurement(track);
    add_doubts(track);
    return track;
}

} // namespace culm::measure
