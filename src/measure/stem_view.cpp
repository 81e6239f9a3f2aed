// SPDX-License-Identifier: BSD-3-Clause
#include "measure/stem_view.hpp"

#include "core/error.hpp"
#include "measure/order_statistics.hpp"
#include "measure/stem_contrast.hpp"

#include <algorithm>
#include <array>

#include <fmt/core.h>

namespace culm::measure {
namespace {

/// A chain and the width of the picture in which it was found.
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
        std::vector<float> peaks;
        for (const RowRun& run : sighting.chain.runs)
            peaks.push_back(run.peak);
        score += sighting.chain.score * double(median(std::move(peaks))) / sighting.noise;
    }
    return score;
}

/// How far the stem's lowest and highest tenth move between the frames.
struct EndMotion {
    double bottom = 0.0;
    double top = 0.0;
};

EndMotion end_motion(const std::vector<FrameImage>& frames, const StemView& view,
                     double stem_width) {
    std::vector<double> bottoms;
    std::vector<double> tops;
    for (const FrameImage& frame : frames) {
        const std::vector<RowRun> runs = look(frame, view, stem_width).chain.runs;
        if (runs.empty())
            continue;
        std::vector<double> low;
        std::vector<double> high;
        for (std::size_t i = 0; i < runs.size() / 10 + 1; ++i) {
            low.push_back(runs[i].median_column());
            high.push_back(runs[runs.size() - 1 - i].median_column());
        }
        bottoms.push_back(median(std::move(low)));
        tops.push_back(median(std::move(high)));
    }
    const auto spread = [](const std::vector<double>& values) {
        return values.empty() ? 0.0 : std::ranges::max(values) - std::ranges::min(values);
    };
    return {spread(bottoms), spread(tops)};
}

} // namespace

double expected_stem_width(const TrackSettings& settings) {
    return std::max(2.0,
                    section_depth(settings.description.stem.section) / settings.metres_per_pixel);
}

TraceOptions first_trace_options(const BandImage& contrast, double noise, double stem_width) {
    TraceOptions options;
    options.stem_width = stem_width;
    options.bottom_row = contrast.height;
    options.threshold_by_row.assign(std::size_t(contrast.height), static_cast<float>(5.0 * noise));
    return options;
}

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
            "pixels wide (the stem's width over mm_per_px) stand out from the noise",
            source, frames.size(), width));
    if (!settings.up) {
        const EndMotion motion = end_motion(frames, best, width);
        if (motion.bottom > motion.top)
            best.up = best.up == Up::DecreasingRow ? Up::IncreasingRow : Up::IncreasingColumn;
    }
    return best;
}

} // namespace culm::measure
