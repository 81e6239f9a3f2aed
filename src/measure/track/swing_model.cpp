// SPDX-License-Identifier: BSD-3-Clause
#include "core/order_statistics.hpp"
#include "measure/release/release_curve.hpp"
#include "measure/track/ring_down.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>

#include <Eigen/Dense>
#include <fmt/core.h>

namespace culm::measure {

namespace {

/// Index of the frame with this number at or after `from`; none if it is missing.
std::optional<std::size_t> index_of(const std::vector<int>& numbers, std::size_t from, int number) {
    const auto found =
        std::lower_bound(numbers.begin() + std::ptrdiff_t(from), numbers.end(), number);
    if (found == numbers.end() || *found != number)
        return std::nullopt;
    return std::size_t(found - numbers.begin());
}

/// Calls use(y(n), y(n+L), y(n+2L), index of the last) for all complete triples of one history.
template <class Use>
void for_each_triple(const std::vector<int>& numbers, const std::vector<double>& history, int lag,
                     std::size_t begin, std::size_t end, const Use& use) {
    for (std::size_t k = begin; k < end; ++k) {
        const auto second = index_of(numbers, k, numbers[k] + lag);
        const auto third = index_of(numbers, k, numbers[k] + 2 * lag);
        if (!second || !third || *third >= end)
            continue;
        const double sum = history[k] + history[*second] + history[*third];
        if (!std::isnan(sum))
            use(history[k], history[*second], history[*third], *third);
    }
}

std::string jump_between(int before, int after) {
    return fmt::format("between the frames {} and {} the swing jumps as if frames were lost or "
                       "doubled there; give their numbers as missing_frames if so",
                       before, after);
}

/// Reports passages through the rest that are too early or too late, until the swing has settled.
void judge_passages(const SwingRelease& release, double relative_height, double settled,
                    std::vector<std::string>& remarks) {
    const std::vector<double>& passages = release.passages;
    // A jump does not change the median time between passages.
    const double period =
        passages.size() < 5 ? release.period : 2.0 * core::median_interval(passages);
    const ReleaseCurve curve{relative_height, period, release.decay_per_cycle};
    const double tolerance =
        (0.04 + 2.0 * release.noise / std::abs(release.held - release.rest)) * period;
    double before = release.time;
    double expected = curve.first_passage();
    for (const double passage : passages) {
        if (before > settled)
            break;
        if (std::abs(passage - before - expected) > tolerance)
            remarks.push_back(jump_between(int(std::floor(before)), int(std::ceil(passage))));
        before = passage;
        expected = 0.5 * period;
    }
}

/// Largest distance from the rest within one period of a frame.
double amplitude_at(const std::vector<double>& history, std::size_t frame, std::size_t period,
                    double rest) {
    double amplitude = 0.0;
    const std::size_t end = std::min(history.size(), frame + period);
    for (std::size_t i = frame - std::min(frame, period); i < end; ++i)
        if (const double size = std::abs(history[i] - rest); size > amplitude)
            amplitude = size;
    return amplitude;
}

void judge_surprises(const std::vector<int>& numbers, const std::vector<double>& history,
                     const SwingRelease& release, const SwingModel& model, std::size_t settled,
                     std::vector<std::string>& remarks) {
    const std::vector<double> surprises = swing_surprises(numbers, history, model, release.rest);
    const std::vector<double> usual = known(std::span(surprises).subspan(settled));
    if (usual.size() < 12)
        return;
    const double deviation = std::max(core::robust_deviation(usual), 0.01);
    const auto period = std::size_t(std::ceil(release.period));
    for (std::size_t k = settled; k < surprises.size(); ++k) {
        const double amplitude = amplitude_at(history, k, period, release.rest);
        if (std::abs(surprises[k]) > std::max(10.0 * deviation, 0.12 * amplitude)) {
            remarks.push_back(jump_between(numbers[k - 1], numbers[k]));
            k += 2; // one lost frame also disturbs the prediction of the next one
        }
    }
}

constexpr double not_recorded = std::numeric_limits<double>::quiet_NaN();

/// 1, 2 or 5 times a power of ten, the smallest that is not below `value`.
double round_step(double value) {
    const double power = std::pow(10.0, std::floor(std::log10(value)));
    for (const double factor : {1.0, 2.0, 5.0})
        if (factor * power >= value * (1.0 - 1e-9))
            return factor * power;
    return 10.0 * power;
}

struct LineValue {
    double column = not_recorded;
    double uncertainty = not_recorded;
};

/// Value at `row` of the least-squares line through the seen rows; `columns` and `uncertainties`
/// contain one frame. The errors of the rows are independent.
LineValue line_value(const double* columns, const double* uncertainties, int row_count, double row,
                     int rows_per_height) {
    const double reach = 0.5 * (rows_per_height + 1);
    const int begin = std::max(0, int(std::ceil(row - reach + 1e-9)));
    const int end = std::min(row_count - 1, int(std::floor(row + reach - 1e-9)));
    double count = 0.0;
    double sum_t = 0.0;
    double sum_tt = 0.0;
    double lowest = std::numeric_limits<double>::infinity();
    double highest = -lowest;
    for (int r = begin; r <= end; ++r) {
        if (std::isnan(columns[r]))
            continue;
        const double t = r - row;
        count += 1.0;
        sum_t += t;
        sum_tt += t * t;
        lowest = std::min(lowest, t);
        highest = std::max(highest, t);
    }
    // At least half of the rows must be seen, on both sides: a line is not extrapolated.
    const int wanted = end - begin + 1;
    if (count == 0.0 || 2.0 * count < wanted || lowest > 0.5 || highest < -0.5)
        return {};
    const double determinant = count * sum_tt - sum_t * sum_t;
    if (determinant <= 0.0 && !(std::abs(lowest) < 1e-6)) // one row is valid only at itself
        return {};
    double value = 0.0;
    double variance = 0.0;
    for (int r = begin; r <= end; ++r) {
        if (std::isnan(columns[r]))
            continue;
        // The intercept of the normal equations; t = 0 is the row itself.
        const double weight = determinant > 0.0 ? (sum_tt - (r - row) * sum_t) / determinant : 1.0;
        value += weight * columns[r];
        variance += std::pow(weight * uncertainties[r], 2);
    }
    return {value, std::sqrt(variance)};
}

} // namespace

std::optional<SwingModel> fit_swing(const AxisRecord& record, std::size_t begin, std::size_t end,
                                    double period) {
    SwingModel model;
    model.lag = std::max(1, int(std::lround(period / 8.0)));
    Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    std::size_t triples = 0;
    for (std::size_t h = 0; h < record.places.size(); ++h) {
        const std::vector<double> history = record.history(h);
        Eigen::Vector3d mean = Eigen::Vector3d::Zero();
        double count = 0.0;
        const auto add = [&](double first, double second, double third, std::size_t) {
            mean += Eigen::Vector3d(first, second, third);
            count += 1.0;
        };
        for_each_triple(record.numbers, history, model.lag, begin, end, add);
        // Differences from the means contain no rest position.
        const Eigen::Vector3d centre = mean / std::max(1.0, count);
        const auto accumulate = [&](double first, double second, double third, std::size_t) {
            const Eigen::Vector2d before(second - centre[1], first - centre[0]);
            normal += before * before.transpose();
            right += before * (third - centre[2]);
        };
        for_each_triple(record.numbers, history, model.lag, begin, end, accumulate);
        triples = std::max(triples, std::size_t(count));
    }
    if (triples < 12 || normal.determinant() <= 1e-9 * normal.trace() * normal.trace())
        return std::nullopt;
    // Prony's method for one damped sine, with a lag that limits the influence of noise.
    const Eigen::Vector2d solution = normal.ldlt().solve(right);
    model.a = solution[0];
    model.b = solution[1];
    return model;
}

std::vector<double> swing_surprises(const std::vector<int>& numbers,
                                    const std::vector<double>& history, const SwingModel& model,
                                    double rest) {
    std::vector<double> surprises(history.size(), not_recorded);
    const auto note = [&](double first, double second, double third, std::size_t k) {
        surprises[k] = third - rest - model.a * (second - rest) - model.b * (first - rest);
    };
    for_each_triple(numbers, history, model.lag, 0, history.size(), note);
    return surprises;
}

std::vector<std::string> find_jumps(const std::vector<int>& numbers,
                                    const std::vector<double>& history, const SwingRelease& release,
                                    double relative_height, const SwingModel& model,
                                    std::size_t settled) {
    std::vector<std::string> remarks;
    judge_passages(release, relative_height, numbers[std::min(settled, numbers.size() - 1)],
                   remarks);
    judge_surprises(numbers, history, release, model, settled, remarks);
    return remarks;
}

std::vector<double> AxisRecord::history(std::size_t place) const {
    std::vector<double> values(numbers.size());
    for (std::size_t k = 0; k < values.size(); ++k)
        values[k] = at(k, place);
    return values;
}

double AxisRecord::seen(std::size_t place) const {
    return double(known(history(place)).size()) / double(std::max<std::size_t>(1, numbers.size()));
}

std::vector<double> known(std::span<const double> values) {
    std::vector<double> result;
    std::ranges::copy_if(values, std::back_inserter(result),
                         [](double value) { return !std::isnan(value); });
    return result;
}

std::vector<double> spaced_heights(const AxisRecord& rows, double clamp_row, double step,
                                   double millimetres_per_pixel) {
    std::size_t top = 0;
    while (top < rows.places.size() && rows.seen(top) < 0.9)
        ++top;
    std::vector<double> heights;
    if (top == rows.places.size())
        return heights;
    const double highest = clamp_row - rows.places[top];
    const double spacing =
        step > 0.0 ? step
                   : round_step(highest * millimetres_per_pixel / 25.0) / millimetres_per_pixel;
    for (int k = 1; k * spacing <= highest; ++k)
        heights.push_back(k * spacing);
    return heights;
}

AxisRecord at_heights(const AxisRecord& rows, double clamp_row, const std::vector<double>& heights,
                      int rows_per_height) {
    AxisRecord record{rows.numbers, rows.times, heights, {}, {}};
    for (std::size_t k = 0; k < rows.numbers.size(); ++k)
        for (const double height : heights) {
            const std::size_t frame = k * rows.places.size();
            const LineValue value =
                line_value(rows.columns.data() + frame, rows.uncertainties.data() + frame,
                           int(rows.places.size()), clamp_row - height, rows_per_height);
            record.columns.push_back(value.column);
            record.uncertainties.push_back(value.uncertainty);
        }
    return record;
}

} // namespace culm::measure
