// SPDX-License-Identifier: BSD-3-Clause
#include "measure/swing_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Dense>

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

} // namespace

double SwingModel::cycles_per_frame() const {
    const double decay = std::sqrt(std::max(0.0, -b));
    const double cosine = decay > 0.0 ? a / (2.0 * decay) : 2.0;
    if (std::abs(cosine) >= 1.0)
        return 0.0;
    return std::acos(cosine) / (2.0 * std::numbers::pi * lag);
}

double SwingModel::decay_per_frame() const {
    return b < 0.0 && b > -1.0 ? -std::log(-b) / (2.0 * lag) : 0.0;
}

std::optional<SwingModel> fit_swing(const AxisRecord& record, std::size_t begin, std::size_t end,
                                    double period) {
    SwingModel model;
    model.lag = std::max(1, int(std::lround(period / 8.0)));
    Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    std::vector<Eigen::Vector3d> means;
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
        means.emplace_back(
            count > 0.0 ? Eigen::Vector3d(mean / count)
                        : Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
        // Differences from the means carry no rest position.
        const Eigen::Vector3d centre = means.back();
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
    const Eigen::Vector2d solution = normal.ldlt().solve(right);
    model.a = solution[0];
    model.b = solution[1];
    const double stiffness = 1.0 - model.a - model.b; // 0 if the recurrence has no rest position
    if (!(stiffness > 1e-3))
        return std::nullopt;
    for (const Eigen::Vector3d& mean : means)
        model.rest.push_back((mean[2] - model.a * mean[1] - model.b * mean[0]) / stiffness);
    return model;
}

std::vector<double> swing_surprises(const std::vector<int>& numbers,
                                    const std::vector<double>& history, const SwingModel& model,
                                    double rest) {
    std::vector<double> surprises(history.size(), std::numeric_limits<double>::quiet_NaN());
    const auto note = [&](double first, double second, double third, std::size_t k) {
        surprises[k] = third - rest - model.a * (second - rest) - model.b * (first - rest);
    };
    for_each_triple(numbers, history, model.lag, 0, history.size(), note);
    return surprises;
}

} // namespace culm::measure
