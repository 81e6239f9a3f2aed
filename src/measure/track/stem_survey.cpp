// SPDX-License-Identifier: BSD-3-Clause
#include "core/error.hpp"
#include "core/order_statistics.hpp"
#include "measure/track/track.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <vector>

#include <fmt/core.h>

namespace culm::measure {

namespace {

/// Threshold of a first trace: five times the noise, the same in all rows.
TraceOptions first_trace_options(const BandImage& contrast, double noise, double stem_width) {
    TraceOptions options;
    options.stem_width = stem_width;
    options.bottom_row = contrast.height;
    options.threshold_by_row.assign(std::size_t(contrast.height), static_cast<float>(5.0 * noise));
    return options;
}

/// Median of a property of the runs.
template <class Property>
double median_of(std::span<const RowRun> runs, const Property& property) {
    std::vector<double> values;
    for (const RowRun& run : runs)
        values.push_back(std::invoke(property, run));
    return core::median(std::move(values));
}

/// A chain and the noise of the contrast in which it was found.
struct Sighting {
    StemChain chain;
    double noise = 0.0;
};

Sighting look(const FrameImage& frame, const StemView& view, double stem_width) {
    const BandImage contrast =
        stem_contrast(upright_band(frame, view.band, view.up), view.sign, stem_width);
    const double noise = contrast_noise(contrast);
    return {trace_stem(contrast, first_trace_options(contrast, noise, stem_width)), noise};
}

/// Length times clarity, summed over the frames.
double view_score(const std::vector<FrameImage>& frames, const StemView& view, double stem_width) {
    double score = 0.0;
    for (const FrameImage& frame : frames) {
        const Sighting sighting = look(frame, view, stem_width);
        if (sighting.chain.runs.empty())
            continue;
        score +=
            sighting.chain.score * median_of(sighting.chain.runs, &RowRun::peak) / sighting.noise;
    }
    return score;
}

/// Does the stem's lowest tenth move farther between the frames than its highest?
bool is_upside_down(const std::vector<FrameImage>& frames, const StemView& view,
                    double stem_width) {
    std::vector<double> bottoms;
    std::vector<double> tops;
    for (const FrameImage& frame : frames) {
        const std::vector<RowRun> runs = look(frame, view, stem_width).chain.runs;
        if (runs.empty())
            continue;
        const std::size_t tenth = runs.size() / 10 + 1;
        bottoms.push_back(median_of(std::span(runs).first(tenth), &RowRun::median_column));
        tops.push_back(median_of(std::span(runs).last(tenth), &RowRun::median_column));
    }
    const auto spread = [](const std::vector<double>& values) {
        return values.empty() ? 0.0 : std::ranges::max(values) - std::ranges::min(values);
    };
    return spread(bottoms) > spread(tops);
}

/// Expected width of the stem in the picture, pixels: its depth over the scale, at least 2.
double expected_stem_width(const TrackSettings& settings) {
    return std::max(2.0,
                    section_depth(settings.description.stem.section) / settings.metres_per_pixel);
}

/// Tries every orientation, band and sign that the settings do not specify on these frames; selects
/// the view with the longest and clearest chains. Throws core::InputError if none shows a stem.
StemView choose_view(const std::vector<FrameImage>& frames, const TrackSettings& settings,
                     const std::string& source) {
    const double width = expected_stem_width(settings);
    std::vector<Up> ups{Up::DecreasingRow, Up::DecreasingColumn};
    if (settings.up)
        ups = {*settings.up};
    std::vector<Band> bands{Band::Red};
    if (frames.front().bands > 1 && settings.band)
        bands = {*settings.band};
    else if (frames.front().bands > 1)
        bands = {Band::Red, Band::Green, Band::Blue};
    std::vector<int> signs{1, -1};
    if (settings.stem_sign)
        signs = {*settings.stem_sign};

    StemView best;
    double best_score = 0.0;
    for (const Up up : ups)
        for (const Band band : bands)
            for (const int sign : signs) {
                const StemView view{up, band, sign};
                if (const double score = view_score(frames, view, width); score > best_score) {
                    best_score = score;
                    best = view;
                }
            }
    if (best_score == 0.0)
        throw core::InputError(fmt::format(
            "{}: no stem is visible: in none of {} frames looked at does a line about {:.1f} "
            "pixels wide (the stem's width over mm_per_px) differ from the noise",
            source, frames.size(), width));
    if (!settings.up && is_upside_down(frames, best, width))
        best.up = best.up == Up::DecreasingRow ? Up::IncreasingRow : Up::IncreasingColumn;
    return best;
}

void check_size(const FrameImage& frame, const TrackSettings& settings) {
    if (frame.width < 8 || frame.height < 8)
        throw core::InputError(fmt::format("{}: frames of {} x {} pixels are too small to track",
                                           settings.file.string(), frame.width, frame.height));
    if ((settings.width && *settings.width != frame.width) ||
        (settings.height && *settings.height != frame.height))
        throw core::InputError(fmt::format(
            "{}: video.width_px, video.height_px say {} x {}; the frames have {} x {} pixels",
            settings.file.string(), settings.width.value_or(frame.width),
            settings.height.value_or(frame.height), frame.width, frame.height));
}

/// Fills NaN from the nearest value, then takes the median of 31 rows.
std::vector<float> smoothed(std::vector<float> values) {
    const auto is_known = [](float value) { return !std::isnan(value); };
    const auto first = std::ranges::find_if(values, is_known);
    if (first == values.end())
        return values;
    std::fill(values.begin(), first, *first);
    for (std::size_t r = 1; r < values.size(); ++r)
        if (std::isnan(values[r]))
            values[r] = values[r - 1];
    std::vector<float> result(values.size());
    constexpr std::ptrdiff_t reach = 15;
    for (std::ptrdiff_t r = 0; r < std::ptrdiff_t(values.size()); ++r)
        result[std::size_t(r)] = core::median(std::vector<float>(
            values.begin() + std::max<std::ptrdiff_t>(0, r - reach),
            values.begin() + std::min(std::ptrdiff_t(values.size()), r + reach + 1)));
    return result;
}

/// The runs of the chains in all pictures.
struct ChainRuns {
    std::vector<RowRun> lowest; ///< of each chain
    std::vector<RowRun> all;
};

ChainRuns trace_all(const std::vector<BandImage>& contrasts, const TraceOptions& options) {
    ChainRuns found;
    for (const BandImage& contrast : contrasts)
        if (const StemChain chain = trace_stem(contrast, options); !chain.runs.empty()) {
            found.lowest.push_back(chain.runs.front());
            found.all.insert(found.all.end(), chain.runs.begin(), chain.runs.end());
        }
    return found;
}

/// The stem's contrast in every row, smoothed over rows.
std::vector<float> contrast_by_row(const std::vector<RowRun>& runs, std::size_t rows) {
    std::vector<std::vector<float>> peaks(rows);
    for (const RowRun& run : runs)
        peaks[std::size_t(run.row)].push_back(run.peak);
    std::vector<float> medians;
    medians.reserve(rows);
    for (std::vector<float>& row : peaks)
        medians.push_back(core::median(std::move(row)));
    return smoothed(std::move(medians));
}

void set_thresholds(StemSurvey& survey, const ChainRuns& runs, const TrackSettings& settings) {
    const std::vector<float> contrast =
        contrast_by_row(runs.all, survey.trace.threshold_by_row.size());
    survey.contrast = core::median(contrast);
    for (std::size_t r = 0; r < contrast.size(); ++r)
        survey.trace.threshold_by_row[r] =
            settings.threshold
                ? static_cast<float>(*settings.threshold)
                : std::max(0.5F * contrast[r], static_cast<float>(4.0 * survey.noise));
}

void find_clamp(StemSurvey& survey, const std::vector<RowRun>& lowest,
                const TrackSettings& settings, int upright_height) {
    const double bottom_row = median_of(lowest, &RowRun::row);
    const double clamp = settings.clamp.value_or(0.0);
    const double axis = settings.axis.value_or(0.0);
    const PixelPoint given =
        in_upright(is_sideways(survey.view.up) ? PixelPoint{clamp, axis} : PixelPoint{axis, clamp},
                   survey.frame_width, survey.frame_height, survey.view.up);
    survey.clamp_row = settings.clamp ? given.row : bottom_row + 0.5;
    if (!settings.clamp && bottom_row + 2 >= upright_height)
        survey.remarks.emplace_back(
            "the stem reaches the picture's border: where it is clamped is not seen; heights count "
            "from that border unless clamp_row (clamp_column) is given");
    survey.trace.bottom_row = std::clamp(int(std::ceil(survey.clamp_row)), 1, upright_height);
    survey.trace.axis_column =
        settings.axis ? given.column : median_of(lowest, &RowRun::median_column);
}

} // namespace

std::vector<std::size_t> evenly_spaced(std::span<const std::size_t> wanted, std::size_t count) {
    if (wanted.size() <= count)
        return {wanted.begin(), wanted.end()};
    std::vector<std::size_t> chosen;
    for (std::size_t k = 0; k < count; ++k)
        chosen.push_back(wanted[k * (wanted.size() - 1) / (count - 1)]);
    return chosen;
}

StemSurvey survey_stem(const FrameSource& source, std::span<const std::size_t> wanted,
                       const TrackSettings& settings, int threads) {
    StemSurvey survey;
    std::vector<FrameImage> frames(std::min<std::size_t>(6, wanted.size()));
    source.for_each(evenly_spaced(wanted, frames.size()), threads,
                    [&](std::size_t i, const FrameImage& frame) { frames[i] = frame; });
    check_size(frames.front(), settings);
    survey.frame_width = frames.front().width;
    survey.frame_height = frames.front().height;
    survey.bands = frames.front().bands;
    survey.view = choose_view(frames, settings, source.name());
    frames.clear();

    const double width = expected_stem_width(settings);
    const std::vector<std::size_t> sample = evenly_spaced(wanted, 40);
    std::vector<BandImage> contrasts(sample.size());
    std::vector<double> noises(sample.size());
    source.for_each(sample, threads, [&](std::size_t i, const FrameImage& frame) {
        contrasts[i] = stem_contrast(upright_band(frame, survey.view.band, survey.view.up),
                                     survey.view.sign, width);
        noises[i] = contrast_noise(contrasts[i]);
    });
    for (const BandImage& contrast : contrasts)
        if (contrast.width != contrasts.front().width ||
            contrast.height != contrasts.front().height)
            throw core::InputError(fmt::format("{}: the frames differ in size", source.name()));
    survey.noise = core::median(noises);
    survey.trace = first_trace_options(contrasts.front(), survey.noise, width);
    survey.trace.clutter = find_still_clutter(contrasts, survey.trace);

    set_thresholds(survey, trace_all(contrasts, survey.trace), settings);
    const ChainRuns runs = trace_all(contrasts, survey.trace);
    if (runs.all.empty())
        throw core::InputError(fmt::format(
            "{}: no stem exceeds the threshold {:.3g}; the contrast is {:.3g} grey values",
            source.name(), survey.trace.threshold_by_row.front(), survey.contrast));
    find_clamp(survey, runs.lowest, settings, contrasts.front().height);
    survey.apparent_width = median_of(runs.all, &RowRun::width);
    return survey;
}

} // namespace culm::measure
