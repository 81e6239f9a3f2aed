// SPDX-License-Identifier: BSD-3-Clause
#include "measure/stem_trace.hpp"

#include <algorithm>
#include <cmath>

namespace culm::measure {
namespace {

constexpr double steepest_slope = 1.0; // columns per row: 45°
constexpr std::size_t runs_per_row = 8;

class RunFinder {
  public:
    RunFinder(const BandImage& contrast, const TraceOptions& options)
        : contrast_(contrast), options_(options),
          narrowest_(std::max(1.0, 0.35 * options.stem_width)),
          widest_(4.0 * options.stem_width + 2.0) {}

    /// Candidates of one row; of many the highest.
    [[nodiscard]] std::vector<RowRun> in_row(int r) const {
        std::vector<RowRun> runs;
        const float* row = contrast_.row(r);
        const float threshold = options_.threshold_by_row[std::size_t(r)];
        for (int c = 0; c < contrast_.width; ++c) {
            if (!is_logical(r, c, row[c], threshold))
                continue;
            RowRun run{r, c, c, 0.0F};
            // One dark pixel, of noise or dust, does not end a run.
            while (run.end < contrast_.width &&
                   (is_logical(r, run.end, row[run.end], threshold) ||
                    (run.end + 1 < contrast_.width &&
                     is_logical(r, run.end + 1, row[run.end + 1], threshold)))) {
                run.peak = std::max(run.peak, row[run.end]);
                ++run.end;
            }
            c = run.end;
            if (can_be_stem(run))
                runs.push_back(run);
        }
        if (runs.size() > runs_per_row) {
            std::ranges::stable_sort(runs, std::ranges::greater{}, &RowRun::peak);
            runs.resize(runs_per_row);
        }
        return runs;
    }

  private:
    [[nodiscard]] bool is_logical(int r, int c, float value, float threshold) const {
        return value > threshold &&
               (options_.clutter.empty() ||
                options_.clutter[std::size_t(r) * std::size_t(contrast_.width) + std::size_t(c)] ==
                    0);
    }
    [[nodiscard]] bool can_be_stem(const RowRun& run) const {
        if (run.begin == 0 || run.end >= contrast_.width || run.width() < narrowest_ ||
            run.width() > widest_)
            return false;
        if (std::isnan(options_.axis_column))
            return true;
        const double reach =
            3.0 * options_.stem_width + steepest_slope * std::max(0, options_.bottom_row - run.row);
        return std::abs(run.median_column() - options_.axis_column) <= reach;
    }

    const BandImage& contrast_;
    const TraceOptions& options_;
    double narrowest_;
    double widest_;
};

/// A run with the best chain that ends in it.
struct Node {
    RowRun run;
    double score = 0.0;
    std::ptrdiff_t below = -1;
};

double own_score(const RowRun& run, const TraceOptions& options) {
    const double fill = std::min(1.0, run.width() / options.stem_width);
    const double excess = run.width() / (2.0 * options.stem_width);
    return excess > 1.0 ? fill / excess : fill;
}

/// Rows that a chain may skip, in pixels: where a crumb hides the stem, and a blot.
struct Gaps {
    explicit Gaps(double stem_width)
        : small(std::max(12.0, 2.0 * stem_width)), largest(std::max(12.0, 8.0 * stem_width)) {}
    double small;
    double largest;
};

/// Score of stepping from `below` to `above`; negative infinity if no stem bends like that. Beyond
/// a large gap a good piece of stem must follow, dust is not worth it.
double step_score(const RowRun& below, const RowRun& above, const Gaps& gaps) {
    const int rows = below.row - above.row;
    const double sideways = std::abs(above.median_column() - below.median_column());
    if (sideways > steepest_slope * rows + 2.0)
        return -std::numeric_limits<double>::infinity();
    return -0.1 * sideways / rows - 0.05 * (rows - 1) - 0.3 * std::max(0.0, rows - gaps.small);
}

} // namespace

StemChain trace_stem(const BandImage& contrast, const TraceOptions& options) {
    const RunFinder finder(contrast, options);
    const Gaps gaps(options.stem_width);
    std::vector<Node> nodes;
    std::vector<std::size_t> first_of_row; // of the rows done so far, from the lowest up
    std::ptrdiff_t best = -1;
    for (int r = std::min(options.bottom_row, contrast.height) - 1; r >= 0; --r) {
        first_of_row.push_back(nodes.size());
        const std::size_t rows_done = first_of_row.size();
        const std::size_t reach = std::min<std::size_t>(rows_done, std::size_t(gaps.largest) + 1);
        const std::size_t reachable = first_of_row[rows_done - reach];
        const std::size_t this_row = nodes.size();
        for (const RowRun& run : finder.in_row(r)) {
            Node node{run, 0.0, -1};
            for (std::size_t k = reachable; k < this_row; ++k) {
                const double score = nodes[k].score + step_score(nodes[k].run, run, gaps);
                if (score > node.score) {
                    node.score = score;
                    node.below = static_cast<std::ptrdiff_t>(k);
                }
            }
            node.score += own_score(run, options);
            nodes.push_back(node);
            if (best < 0 || node.score > nodes[std::size_t(best)].score)
                best = static_cast<std::ptrdiff_t>(nodes.size()) - 1;
        }
    }
    StemChain chain;
    if (best >= 0)
        chain.score = nodes[std::size_t(best)].score;
    for (std::ptrdiff_t k = best; k >= 0; k = nodes[std::size_t(k)].below)
        chain.runs.push_back(nodes[std::size_t(k)].run);
    std::ranges::reverse(chain.runs);
    const double shortest = std::max(8.0, 2.0 * options.stem_width);
    if (chain.score < shortest)
        return {};
    return chain;
}

} // namespace culm::measure
