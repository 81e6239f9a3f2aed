// SPDX-License-Identifier: BSD-3-Clause
#include "measure/track/stem_trace.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <opencv2/imgproc.hpp>

namespace culm::measure {

namespace {

constexpr double window_in_stem_widths = 8.0;

/// The value that would stand at size/2 of the sorted sample. For the fifty or so values of a
/// window, counting in SIMD registers is faster than a partial sort.
float median(const std::vector<float>& sample) {
    const auto rank = static_cast<int>(sample.size() / 2);
    float lower = -std::numeric_limits<float>::infinity(); // the median is above
    float upper = std::numeric_limits<float>::infinity();  // and below
    for (const float candidate : sample) {
        if (!(lower < candidate && candidate < upper))
            continue;
        int below = 0;
        int not_above = 0;
        for (const float value : sample) {
            below += value < candidate ? 1 : 0;
            not_above += value <= candidate ? 1 : 0;
        }
        if (below <= rank && rank < not_above)
            return candidate;
        (below > rank ? upper : lower) = candidate;
    }
    return std::numeric_limits<float>::quiet_NaN(); // of a sample with a NaN
}

/// Median of a row in a window around nodes that are `spacing` pixels apart; the last node is
/// beyond the last pixel.
std::vector<float> background_nodes(const float* row, int width, double stem_width, int spacing) {
    const int window =
        std::clamp(int(std::lround(window_in_stem_widths * stem_width)), 3, std::max(3, width));
    const int stride = std::max(1, int(stem_width / 5.0));
    std::vector<float> nodes(std::size_t((width - 1) / spacing + 2));
    std::vector<float> sample;
    for (std::size_t k = 0; k < nodes.size(); ++k) {
        // At the border the window keeps its size: a narrower one would hold too much stem.
        const int centre = std::min(int(k) * spacing, width - 1);
        const int begin = std::clamp(centre - window / 2, 0, std::max(0, width - window));
        const int end = std::min(width, begin + window);
        sample.resize(std::size_t((end - begin + stride - 1) / stride));
        for (std::size_t i = 0; i < sample.size(); ++i)
            sample[i] = row[std::size_t(begin) + i * std::size_t(stride)];
        nodes[k] = median(sample);
    }
    return nodes;
}

/// Connected regions of high contrast in all pictures.
struct StillPieces {
    cv::Mat labels; ///< 32-bit, 0 = nothing
    cv::Mat blots;  ///< 8-bit, 1 = high contrast, but too wide for the stem; in no piece
    int count = 0;  ///< with label 0
    std::vector<cv::Rect> boxes;
};

/// Removes runs that are too wide for the stem, and the pixels next to them, from the mask.
cv::Mat take_blots(cv::Mat& mask, double stem_width) {
    const double widest = 1.5 * stem_width + 2.0;
    cv::Mat blots(mask.size(), CV_8U, cv::Scalar(0));
    for (int r = 0; r < mask.rows; ++r)
        for (int begin = 0; begin < mask.cols; ++begin) {
            int end = begin;
            while (end < mask.cols && mask.at<uchar>(r, end) != 0)
                ++end;
            if (end - begin > widest)
                blots(cv::Rect(begin, r, end - begin, 1)).setTo(1);
            begin = end;
        }
    const int reach = 2 * static_cast<int>(0.5 * stem_width + 1.0) + 1;
    cv::dilate(blots, blots, cv::Mat::ones(reach, reach, CV_8U));
    cv::bitwise_and(blots, mask, blots);
    mask.setTo(0, blots);
    return blots;
}

StillPieces still_pieces(const std::vector<BandImage>& contrasts, const TraceOptions& options) {
    const int width = contrasts.front().width;
    const int height = contrasts.front().height;
    cv::Mat mask(height, width, CV_8U, cv::Scalar(0));
    for (int r = 0; r < height; ++r)
        for (int c = 0; c < width; ++c) {
            const bool is_still = std::ranges::all_of(contrasts, [&](const BandImage& contrast) {
                return contrast.row(r)[c] > options.threshold_by_row[std::size_t(r)];
            });
            mask.at<uchar>(r, c) = is_still ? 1 : 0;
        }
    StillPieces pieces;
    pieces.blots = take_blots(mask, options.stem_width);
    // The still part of the stem breaks up where the stem begins to move; fragments above one
    // another are joined.
    cv::Mat joined;
    const int reach = 2 * static_cast<int>(options.stem_width) + 1;
    cv::dilate(mask, joined, cv::Mat::ones(reach, 1, CV_8U));
    cv::Mat stats;
    cv::Mat centroids;
    pieces.count = cv::connectedComponentsWithStats(joined, pieces.labels, stats, centroids, 8);
    pieces.labels.setTo(0, mask == 0);
    for (int label = 0; label < pieces.count; ++label)
        pieces.boxes.emplace_back(
            stats.at<int>(label, cv::CC_STAT_LEFT), stats.at<int>(label, cv::CC_STAT_TOP),
            stats.at<int>(label, cv::CC_STAT_WIDTH), stats.at<int>(label, cv::CC_STAT_HEIGHT));
    return pieces;
}

/// The blots and all pieces except those with these labels, grown by one pixel.
std::vector<std::uint8_t> clutter_without(const StillPieces& pieces,
                                          const std::vector<bool>& is_stem) {
    cv::Mat mask = pieces.blots.clone();
    for (int r = 0; r < mask.rows; ++r)
        for (int c = 0; c < mask.cols; ++c) {
            const int label = pieces.labels.at<int>(r, c);
            if (label > 0 && !is_stem[std::size_t(label)])
                mask.at<uchar>(r, c) = 1;
        }
    cv::dilate(mask, mask, cv::Mat::ones(3, 3, CV_8U));
    std::vector<std::uint8_t> clutter;
    for (int r = 0; r < mask.rows; ++r)
        clutter.insert(clutter.end(), mask.ptr<uchar>(r), mask.ptr<uchar>(r) + mask.cols);
    return clutter;
}

/// Number of runs that both chains contain.
std::size_t shared_runs(const StemChain& chain, const StemChain& other) {
    return std::size_t(std::ranges::count_if(chain.runs, [&](const RowRun& run) {
        return std::ranges::any_of(other.runs, [&](const RowRun& candidate) {
            return candidate.row == run.row && candidate.begin < run.end &&
                   run.begin < candidate.end;
        });
    }));
}

/// Whether the stem seems to continue in the piece: the chain that may use it contains the moving
/// part and passes through a good part of the piece's rows (its box was grown with it).
bool continues_stem(const StemChain& moving, const StemChain& with_piece, const StillPieces& pieces,
                    int label) {
    const cv::Rect& box = pieces.boxes[std::size_t(label)];
    const auto inside = std::ranges::count_if(with_piece.runs, [&](const RowRun& run) {
        return pieces.labels.at<int>(run.row, (run.begin + run.end - 1) / 2) == label;
    });
    return 10 * shared_runs(moving, with_piece) >= 7 * moving.runs.size() &&
           3 * inside >= box.height;
}

} // namespace

BandImage stem_contrast(const BandImage& image, int sign, double stem_width) {
    BandImage contrast(image.width, image.height);
    const int spacing = std::max(2, int(stem_width / 2.0));
    const auto factor = static_cast<float>(sign);
    for (int r = 0; r < image.height; ++r) {
        const float* row = image.row(r);
        const std::vector<float> nodes = background_nodes(row, image.width, stem_width, spacing);
        for (int c = 0; c < image.width; ++c) {
            const auto k = std::size_t(c / spacing);
            const float fraction = float(c % spacing) / float(spacing);
            const float background = nodes[k] + fraction * (nodes[k + 1] - nodes[k]);
            contrast.row(r)[c] = factor * (row[c] - background);
        }
    }
    return contrast;
}

double contrast_noise(const BandImage& contrast) {
    // A sample is sufficient: every seventh pixel, which is a stride that no column width repeats.
    std::vector<float> sizes;
    sizes.reserve(contrast.values.size() / 7 + 1);
    for (std::size_t i = 0; i < contrast.values.size(); i += 7)
        sizes.push_back(std::abs(contrast.values[i]));
    const std::size_t kept = sizes.size() * 9 / 10;
    if (kept == 0)
        return 0.25;
    std::nth_element(sizes.begin(), sizes.begin() + std::ptrdiff_t(kept), sizes.end());
    double sum = 0.0;
    for (std::size_t i = 0; i < kept; ++i)
        sum += double(sizes[i]) * double(sizes[i]);
    // A normal law cut at ±1.645 standard deviations has 0.789 of its standard deviation.
    return std::max(0.25, std::sqrt(sum / double(kept)) / 0.789);
}

std::vector<std::uint8_t> find_still_clutter(const std::vector<BandImage>& contrasts,
                                             const TraceOptions& options) {
    const StillPieces pieces = still_pieces(contrasts, options);
    std::vector<bool> is_stem(std::size_t(pieces.count), false);
    TraceOptions trial = options;
    trial.clutter = clutter_without(pieces, is_stem);

    // A dozen frames are sufficient to decide about each piece.
    std::vector<std::pair<const BandImage*, StemChain>> moving;
    const std::size_t step = std::max<std::size_t>(1, contrasts.size() / 12);
    std::size_t looked_at = 0;
    for (std::size_t i = 0; i < contrasts.size(); i += step, ++looked_at)
        if (StemChain chain = trace_stem(contrasts[i], trial); !chain.runs.empty())
            moving.emplace_back(&contrasts[i], std::move(chain));
    if (3 * moving.size() < looked_at)
        return {};

    std::vector<int> large; // the rest is dust
    for (int label = 1; label < pieces.count; ++label)
        if (pieces.boxes[std::size_t(label)].height >= 4)
            large.push_back(label);
    std::ranges::sort(large, std::ranges::greater{},
                      [&](int label) { return pieces.boxes[std::size_t(label)].height; });
    if (large.size() > 8)
        large.resize(8);
    for (const int label : large) {
        is_stem[std::size_t(label)] = true;
        trial.clutter = clutter_without(pieces, is_stem);
        const auto votes = std::ranges::count_if(moving, [&](const auto& frame) {
            return continues_stem(frame.second, trace_stem(*frame.first, trial), pieces, label);
        });
        is_stem[std::size_t(label)] = 2 * std::size_t(votes) > moving.size();
    }
    return clutter_without(pieces, is_stem);
}

} // namespace culm::measure
