// SPDX-License-Identifier: BSD-3-Clause
#include "measure/track/row_record.hpp"

#include <algorithm>
#include <cmath>
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

/// Value at `row` of the least-squares line through the seen rows; `columns` holds one frame.
double line_value(const double* columns, int row_count, double row, int rows_per_height) {
    const double reach = 0.5 * (rows_per_height + 1);
    const int begin = std::max(0, int(std::ceil(row - reach + 1e-9)));
    const int end = std::min(row_count - 1, int(std::floor(row + reach - 1e-9)));
    double count = 0.0;
    double sum_t = 0.0;
    double sum_y = 0.0;
    double sum_tt = 0.0;
    double sum_ty = 0.0;
    double lowest = std::numeric_limits<double>::infinity();
    double highest = -lowest;
    for (int r = begin; r <= end; ++r) {
        const double y = columns[r];
        if (std::isnan(y))
            continue;
        const double t = r - row;
        count += 1.0;
        sum_t += t;
        sum_y += y;
        sum_tt += t * t;
        sum_ty += t * y;
        lowest = std::min(lowest, t);
        highest = std::max(highest, t);
    }
    // Half of the rows must be seen, and on both sides: a line is not extrapolated.
    const int wanted = end - begin + 1;
    if (count == 0.0 || 2.0 * count < wanted || lowest > 0.5 || highest < -0.5)
        return not_recorded;
    const double determinant = count * sum_tt - sum_t * sum_t;
    if (determinant <= 0.0) // one row: good only for itself
        return std::abs(lowest) < 1e-6 ? sum_y : not_recorded;
    // The intercept of the normal equations; t = 0 is the row itself.
    return (sum_y * sum_tt - sum_t * sum_ty) / determinant;
}

} // namespace

std::vector<double> AxisRecord::history(std::size_t place) const {
    std::vector<double> values(numbers.size());
    for (std::size_t k = 0; k < values.size(); ++k)
        values[k] = at(k, place);
    return values;
}

double AxisRecord::seen(std::size_t place) const {
    std::size_t count = 0;
    for (std::size_t k = 0; k < numbers.size(); ++k)
        count += std::isnan(at(k, place)) ? 0 : 1;
    return double(count) / double(std::max<std::size_t>(1, numbers.size()));
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
    AxisRecord record{rows.numbers, heights, {}};
    record.columns.reserve(rows.numbers.size() * heights.size());
    for (std::size_t k = 0; k < rows.numbers.size(); ++k)
        for (const double height : heights)
            record.columns.push_back(line_value(rows.columns.data() + k * rows.places.size(),
                                                int(rows.places.size()), clamp_row - height,
                                                rows_per_height));
    return record;
}

} // namespace culm::measure
