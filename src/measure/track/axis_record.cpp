// SPDX-License-Identifier: BSD-3-Clause
#include "measure/track/axis_record.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace culm::measure {

namespace {

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
