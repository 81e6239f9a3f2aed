// SPDX-License-Identifier: BSD-3-Clause
#include "measure/track/stem_trace.hpp"

#include "core/order_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Dense>

namespace culm::measure {

namespace {

constexpr double steepest_slope = 1.0; // columns per row: 45°
constexpr std::size_t runs_per_row = 8;

/// Does the pixel exceed the threshold, and is it not clutter?
bool is_logical(const BandImage& contrast, const TraceOptions& options, int r, int c) {
    return contrast.row(r)[c] > options.threshold_by_row[std::size_t(r)] &&
           (options.clutter.empty() ||
            options.clutter[std::size_t(r) * std::size_t(contrast.width) + std::size_t(c)] == 0);
}

bool can_be_stem(const RowRun& run, int picture_width, const TraceOptions& options) {
    if (run.begin == 0 || run.end >= picture_width ||
        run.width() < std::max(1.0, 0.35 * options.stem_width) ||
        run.width() > 4.0 * options.stem_width + 2.0)
        return false;
    if (std::isnan(options.axis_column))
        return true;
    const double reach =
        3.0 * options.stem_width + steepest_slope * std::max(0, options.bottom_row - run.row);
    return std::abs(run.median_column() - options.axis_column) <= reach;
}

/// Candidates of one row; if there are many, the highest.
std::vector<RowRun> runs_in_row(const BandImage& contrast, const TraceOptions& options, int r) {
    std::vector<RowRun> runs;
    const auto is_bright = [&](int c) {
        return c < contrast.width && is_logical(contrast, options, r, c);
    };
    for (int c = 0; c < contrast.width; ++c) {
        if (!is_bright(c))
            continue;
        RowRun run{r, c, c, 0.0F};
        // One dark pixel, of noise or dust, does not end a run.
        while (run.end < contrast.width && (is_bright(run.end) || is_bright(run.end + 1))) {
            run.peak = std::max(run.peak, contrast.row(r)[run.end]);
            ++run.end;
        }
        c = run.end;
        if (can_be_stem(run, contrast.width, options))
            runs.push_back(run);
    }
    if (runs.size() > runs_per_row) {
        std::ranges::stable_sort(runs, std::ranges::greater{}, &RowRun::peak);
        runs.resize(runs_per_row);
    }
    return runs;
}

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

/// Score of a step from `below` to `above`; negative infinity if no stem bends like that. After a
/// large gap a good piece of stem must follow; dust does not justify it.
double step_score(const RowRun& below, const RowRun& above, const Gaps& gaps) {
    const int rows = below.row - above.row;
    const double sideways = std::abs(above.median_column() - below.median_column());
    if (sideways > steepest_slope * rows + 2.0)
        return -std::numeric_limits<double>::infinity();
    return -0.1 * sideways / rows - 0.05 * (rows - 1) - 0.3 * std::max(0.0, rows - gaps.small);
}

constexpr double not_seen = std::numeric_limits<double>::quiet_NaN();

/// column = a[0] + a[1] t + a[2] t², t = (row − middle)/scale: the paper's preliminary smoothing.
struct HeightQuadratic {
    std::array<double, 3> coefficients{};
    double middle = 0.0;
    double scale = 1.0;
    double deviation = 0.0; ///< robust standard deviation of the row medians about it, pixels

    [[nodiscard]] double at(double row) const {
        const double t = (row - middle) / scale;
        return coefficients[0] + t * (coefficients[1] + t * coefficients[2]);
    }
};

/// Robust least squares through the row medians of a chain (at least 3 runs).
HeightQuadratic fit_quadratic(const std::vector<RowRun>& runs) {
    HeightQuadratic fit;
    fit.middle = 0.5 * (runs.front().row + runs.back().row);
    fit.scale = std::max(1.0, 0.5 * (runs.front().row - runs.back().row));
    std::vector<double> residuals(runs.size(), 0.0);
    double limit = std::numeric_limits<double>::infinity();
    for (int iteration = 0; iteration < 5; ++iteration) {
        Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
        Eigen::Vector3d right = Eigen::Vector3d::Zero();
        for (std::size_t i = 0; i < runs.size(); ++i) {
            // Huber's weights: beyond the limit a row has a constant influence.
            const double size = std::abs(residuals[i]);
            const double weight = size > limit ? limit / size : 1.0;
            const double t = (runs[i].row - fit.middle) / fit.scale;
            const Eigen::Vector3d basis(1.0, t, t * t);
            normal += weight * basis * basis.transpose();
            right += weight * runs[i].median_column() * basis;
        }
        const Eigen::Vector3d solution = normal.ldlt().solve(right);
        fit.coefficients = {solution[0], solution[1], solution[2]};
        for (std::size_t i = 0; i < runs.size(); ++i)
            residuals[i] = runs[i].median_column() - fit.at(runs[i].row);
        fit.deviation = core::robust_deviation(residuals);
        limit = std::max(0.5, 1.5 * fit.deviation);
    }
    return fit;
}

/// Column where the contrast crosses `level`, from `inside` outward in direction `step`.
std::optional<double> crossing(const float* row, int width, int inside, int step, float level) {
    for (int c = inside; c + step >= 0 && c + step < width; c += step) {
        const float here = row[c];
        const float next = row[c + step];
        if (here >= level && next < level)
            return c + step * double((here - level) / (here - next));
    }
    return std::nullopt;
}

/// The middle between the columns where the contrast crosses half of its value in the run.
double middle_of(const BandImage& contrast, const RowRun& run) {
    const float* row = contrast.row(run.row);
    const int inside = (run.begin + run.end - 1) / 2;
    const float plateau = core::quantile(std::vector<float>(row + run.begin, row + run.end), 0.75);
    const auto left = crossing(row, contrast.width, inside, -1, 0.5F * plateau);
    const auto right = crossing(row, contrast.width, inside, +1, 0.5F * plateau);
    if (!left || !right || *right - *left > 2.0 * run.width() + 4.0)
        return not_seen;
    return 0.5 * (*left + *right);
}

/// Whether the run or the two adjacent pixels touch clutter: then an edge is not the stem's.
bool touches_clutter(const RowRun& run, const BandImage& contrast, const TraceOptions& options) {
    if (options.clutter.empty())
        return false;
    const std::size_t row = std::size_t(run.row) * std::size_t(contrast.width);
    const int begin = std::max(0, run.begin - 2);
    const int end = std::min(contrast.width, run.end + 2);
    return std::any_of(options.clutter.begin() + std::ptrdiff_t(row) + begin,
                       options.clutter.begin() + std::ptrdiff_t(row) + end,
                       [](std::uint8_t mark) { return mark != 0; });
}

/// Removes single rows that differ from the median of their neighbours, both relative to the
/// quadratic.
void remove_lone_rows(std::vector<double>& rows, const HeightQuadratic& quadratic) {
    constexpr int neighbours = 8;
    const std::vector<double> before = rows;
    const int height = int(rows.size());
    std::vector<double> around;
    for (int r = 0; r < height; ++r) {
        if (std::isnan(before[std::size_t(r)]))
            continue;
        around.clear();
        for (int k = std::max(0, r - neighbours); k <= std::min(height - 1, r + neighbours); ++k)
            if (!std::isnan(before[std::size_t(k)]))
                around.push_back(before[std::size_t(k)] - quadratic.at(k));
        const double off = before[std::size_t(r)] - quadratic.at(r) - core::median(around);
        const bool is_alone = around.size() < 4;
        if (is_alone || std::abs(off) > std::max(0.6, 5.0 * core::robust_deviation(around)))
            rows[std::size_t(r)] = not_seen;
    }
}

} // namespace

StemChain trace_stem(const BandImage& contrast, const TraceOptions& options) {
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
        for (const RowRun& run : runs_in_row(contrast, options, r)) {
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

int oblique_rows(double stem_width) {
    return int(std::ceil(0.3 * stem_width)) + 1;
}

std::vector<double> axis_columns(const BandImage& contrast, const StemChain& chain,
                                 const TraceOptions& options) {
    std::vector<double> rows(std::size_t(contrast.height), not_seen);
    if (chain.runs.size() < 3)
        return rows;
    const HeightQuadratic quadratic = fit_quadratic(chain.runs);
    // The second mode bends the stem away from a quadratic by more than the noise of a row.
    const double gate = std::max(1.5 * options.stem_width, 6.0 * quadratic.deviation);
    const int top = chain.runs.back().row;
    const int oblique = top <= 1 ? 0 : oblique_rows(options.stem_width);
    for (const RowRun& run : chain.runs) {
        if (run.row < top + oblique || touches_clutter(run, contrast, options) ||
            std::abs(run.median_column() - quadratic.at(run.row)) > gate)
            continue;
        const double middle = middle_of(contrast, run);
        if (std::abs(middle - run.median_column()) <= 0.5 * options.stem_width)
            rows[std::size_t(run.row)] = middle;
    }
    remove_lone_rows(rows, quadratic);
    return rows;
}

} // namespace culm::measure
