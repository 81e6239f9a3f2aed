// SPDX-License-Identifier: BSD-3-Clause
#include "measure/track/matched_row.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Dense>

namespace culm::measure {

namespace {

constexpr double closest_knots = 0.5;     // pixels; closer ones would follow the noise
constexpr double table_step = 1.0 / 16.0; // pixels
constexpr double least_smear = 2.0 * table_step;
constexpr double largest_noise = 4.0; // standard deviations; beyond it a pixel is dust (Huber)

/// Values of the four cubic B-splines on the interval in which u = 0 … 1.
std::array<double, 4> basis(double u) {
    const double v = 1.0 - u;
    return {v * v * v / 6.0, (4.0 + 3.0 * u * u * (u - 2.0)) / 6.0,
            (4.0 + 3.0 * v * v * (v - 2.0)) / 6.0, u * u * u / 6.0};
}

} // namespace

Pixels PixelRow::within(double column, double distance) const {
    return {std::max(0, static_cast<int>(std::ceil(column - distance))),
            std::min(width, static_cast<int>(std::floor(column + distance)) + 1)};
}

StemProfile::StemProfile(double reach)
    : reach_(reach), spacing_(std::max(closest_knots, reach / 40.0)),
      knots_(static_cast<std::size_t>(std::ceil(2.0 * reach / spacing_)) + 3),
      normal_(knots_ * knots_), right_(knots_) {}

void StemProfile::add(const PixelRow& row, double axis) {
    const Pixels around = row.within(axis, beside());
    Eigen::Matrix2d of_line = Eigen::Matrix2d::Zero();
    Eigen::Vector2d line = Eigen::Vector2d::Zero();
    for (int c = around.begin; c < around.end; ++c)
        if (std::abs(c - axis) > reach_ && row.counts(c)) {
            const Eigen::Vector2d by(1.0, c - axis);
            of_line += by * by.transpose();
            line += by * row.values[c];
        }
    line = of_line.ldlt().solve(line);
    const Pixels inside = row.within(axis, reach_);
    for (int c = inside.begin; c < inside.end; ++c) {
        if (!row.counts(c))
            continue;
        const double contrast = row.values[c] - line[0] - line[1] * (c - axis);
        const double place = (c - axis + reach_) / spacing_;
        const std::size_t first = std::min(static_cast<std::size_t>(place), knots_ - 4);
        const std::array<double, 4> weights = basis(place - static_cast<double>(first));
        for (std::size_t i = 0; i < 4; ++i) {
            right_[first + i] += weights[i] * contrast;
            for (std::size_t j = 0; j <= i; ++j)
                normal_[(first + i) * knots_ + first + j] += weights[i] * weights[j];
        }
        ++pixels_;
    }
}

void StemProfile::close() {
    if (pixels_ < 4 * knots_)
        return;
    const auto size = static_cast<Eigen::Index>(knots_);
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    RowMajor normal = Eigen::Map<const RowMajor>(normal_.data(), size, size);
    // If the stem keeps its position between the pixels, some knots have no pixel: a curvature
    // penalty of a thousandth of a pixel's weight joins them to their neighbours.
    const double weight = 1e-3 * static_cast<double>(pixels_) / static_cast<double>(knots_);
    for (Eigen::Index k = 1; k + 1 < size; ++k)
        for (Eigen::Index i = -1; i <= 1; ++i)
            for (Eigen::Index j = -1; j <= i; ++j)
                normal(k + i, k + j) += weight * (i == 0 ? -2.0 : 1.0) * (j == 0 ? -2.0 : 1.0);
    const Eigen::VectorXd solution = normal.selfadjointView<Eigen::Lower>().ldlt().solve(
        Eigen::Map<const Eigen::VectorXd>(right_.data(), size));
    coefficients_.assign(solution.begin(), solution.end());
    values_.clear();
    integrals_.assign(1, 0.0);
    for (std::size_t k = 0; static_cast<double>(k) * table_step <= 2.0 * reach_; ++k)
        values_.push_back(spline(static_cast<double>(k) * table_step / spacing_));
    for (std::size_t k = 1; k < values_.size(); ++k)
        integrals_.push_back(integrals_.back() + 0.5 * table_step * (values_[k - 1] + values_[k]));
}

double StemProfile::spline(double place) const {
    const std::size_t first = std::min(static_cast<std::size_t>(place), knots_ - 4);
    const std::array<double, 4> weights = basis(place - static_cast<double>(first));
    double sum = 0.0;
    for (std::size_t i = 0; i < 4; ++i)
        sum += weights[i] * coefficients_[first + i];
    return sum;
}

double StemProfile::in_table(const std::vector<double>& table, double distance) const {
    const double last = static_cast<double>(table.size()) - 1.001;
    const double place = std::clamp((distance + reach_) / table_step, 0.0, last);
    const auto below = static_cast<std::size_t>(place);
    return table[below] + (place - static_cast<double>(below)) * (table[below + 1] - table[below]);
}

StemProfile::Point StemProfile::between(double low, double high) const {
    const double more = std::max(0.0, 0.5 * (least_smear - (high - low)));
    low -= more;
    high += more;
    const double width = high - low;
    return {(in_table(integrals_, high) - in_table(integrals_, low)) / width,
            (in_table(values_, high) - in_table(values_, low)) / width};
}

StemProfile::Point StemProfile::at(double distance, const Path& path) const {
    constexpr double straight = 0.02; // pixels
    if (std::abs(path.bend) < straight) {
        const double half = 0.5 * std::abs(path.length);
        return between(distance - half, distance + half);
    }
    constexpr int parts = 4; // each at an even speed
    std::array<double, parts + 1> places;
    double mean = 0.0;
    for (int k = 0; k <= parts; ++k) {
        const double time = double(k) / parts - 0.5;
        places[std::size_t(k)] = path.length * time + path.bend * time * time;
        mean += places[std::size_t(k)] * (k == 0 || k == parts ? 0.5 : 1.0) / parts;
    }
    Point sum{0.0, 0.0};
    for (std::size_t k = 0; k < parts; ++k) {
        const double near = std::min(places[k], places[k + 1]) - mean;
        const double far = std::max(places[k], places[k + 1]) - mean;
        const Point part = between(distance - far, distance - near);
        sum.value += part.value / parts;
        sum.slope += part.slope / parts;
    }
    return sum;
}

std::optional<RowMatch> match_row(const StemProfile& profile, const PixelRow& row, double axis,
                                  const Path& path, double noise) {
    // The axis, the stem's brightness, the background's and its slope; and the derivatives of a
    // pixel's grey value by each.
    using Values = Eigen::Vector4d;
    constexpr int most_iterations = 20;
    constexpr double close = 1e-4; // pixels
    const Pixels around = row.within(axis, profile.beside() + 0.5 * path.extent());
    Values values(axis, 1.0, 0.0, 0.0);
    RowMatch found;
    for (int k = 0; k < most_iterations; ++k) {
        Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
        Values right = Values::Zero();
        double squares = 0.0;
        for (int c = around.begin; c < around.end; ++c) {
            if (!row.counts(c))
                continue;
            const StemProfile::Point point = profile.at(c - values[0], path);
            const Values by(-values[1] * point.slope, point.value, 1.0, c - axis);
            const double left = row.values[c] - values.tail<3>().dot(by.tail<3>());
            const double weight =
                k < 3 ? 1.0 : std::min(1.0, largest_noise * noise / std::abs(left));
            normal.noalias() += weight * by * by.transpose();
            right += weight * left * by;
            squares += weight * left * left;
        }
        const auto solver = normal.ldlt();
        const Values step = solver.solve(right);
        if (!step.allFinite() || !(normal.diagonal().minCoeff() > 0.0))
            return std::nullopt;
        found.variance = solver.solve(Values::UnitX())[0];
        found.squares = squares - step.dot(right);
        values += step;
        values[0] -= step[0] - std::clamp(step[0], -1.0, 1.0);
        found.axis = values[0];
        if (!(values[1] > 0.2) || std::abs(found.axis - axis) > 1.0 + 0.3 * path.extent())
            return std::nullopt;
        if (k > 3 && std::abs(step[0]) < close)
            return found.variance > 0.0 ? std::optional(found) : std::nullopt;
    }
    return std::nullopt;
}

void GroundRow::add(const PixelRow& row, double axis, double hidden) {
    sums_.resize(std::size_t(row.width));
    counts_.resize(std::size_t(row.width));
    if (std::isnan(axis) || std::isnan(hidden))
        return;
    for (int c = 0; c < row.width; ++c)
        if (std::abs(c - axis) > hidden) {
            sums_[std::size_t(c)] += row.values[c];
            ++counts_[std::size_t(c)];
        }
}

std::vector<float> GroundRow::mean(double noise) const {
    std::vector<double> known = between_well_seen();
    const double texture = texture_of(noise);
    std::vector<float> mean;
    for (std::size_t c = 0; c < sums_.size(); ++c) {
        const double count = counts_[c];
        const double share = count < fewest ? count * texture / (count * texture + noise) : 0.0;
        mean.push_back(static_cast<float>(share > 0.0 ? std::lerp(known[c], sums_[c] / count, share)
                                                      : known[c]));
    }
    return mean;
}

std::vector<double> GroundRow::between_well_seen() const {
    std::vector<double> mean(sums_.size(), 0.0);
    std::optional<std::size_t> last;
    for (std::size_t c = 0; c < sums_.size(); ++c) {
        if (counts_[c] < fewest)
            continue;
        mean[c] = sums_[c] / counts_[c];
        const std::size_t before = last.value_or(c);
        for (std::size_t k = last ? before + 1 : 0; k < c; ++k)
            mean[k] = std::lerp(mean[before], mean[c],
                                c == before ? 1.0 : double(k - before) / double(c - before));
        last = c;
    }
    if (last)
        std::fill(mean.begin() + std::ptrdiff_t(*last), mean.end(), mean[*last]);
    return mean;
}

double GroundRow::texture_of(double noise) const {
    const std::size_t reach = widest_gap() / 2 + 1;
    double sum = 0.0;
    double count = 0.0;
    for (std::size_t c = reach; c + reach < sums_.size(); ++c) {
        if (std::min({counts_[c - reach], counts_[c], counts_[c + reach]}) < fewest)
            continue;
        const auto mean = [&](std::size_t k) { return sums_[k] / counts_[k]; };
        sum += std::pow(mean(c) - 0.5 * (mean(c - reach) + mean(c + reach)), 2) -
               1.5 * noise / counts_[c];
        count += 1.0;
    }
    return count > 0.0 ? std::max(0.0, sum / count) : 0.0;
}

std::size_t GroundRow::widest_gap() const {
    std::size_t widest = 0;
    std::optional<std::size_t> last;
    for (std::size_t c = 0; c < counts_.size(); ++c)
        if (counts_[c] >= fewest) {
            widest = std::max(widest, c - last.value_or(c - 1) - 1);
            last = c;
        }
    return widest;
}

} // namespace culm::measure
