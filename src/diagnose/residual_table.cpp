// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/residual_table.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace culm::diagnose {
namespace {

/// Adds up readings.
class GroupSum {
  public:
    void add_frame(const calibrate::ChainFit& fit, std::size_t frame) {
        for (std::size_t j = 0; j < fit.prediction.rows; ++j)
            add(fit, frame, j);
    }
    void add(const calibrate::ChainFit& fit, std::size_t frame, std::size_t row) {
        const double residual = fit.residuals[frame * fit.prediction.rows + row];
        if (std::isnan(residual))
            return;
        ++readings_;
        sum_ += residual;
        squares_ += residual * residual;
        whitened_ += std::pow(residual / fit.noise[row], 2);
    }
    [[nodiscard]] ResidualGroup group(double lower, double upper) const {
        const auto count = static_cast<double>(std::max<std::size_t>(readings_, 1));
        return {lower,        upper,
                readings_,    std::sqrt(squares_ / count),
                sum_ / count, std::sqrt(whitened_ / count)};
    }

  private:
    std::size_t readings_ = 0;
    double sum_ = 0.0;
    double squares_ = 0.0;
    double whitened_ = 0.0;
};

} // namespace

Eigen::MatrixXd whitened_residuals(const calibrate::ChainFit& fit) {
    const std::size_t rows = fit.prediction.rows;
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(fit.times.size()),
                                                   static_cast<Eigen::Index>(rows));
    for (std::size_t i = 0; i < fit.times.size(); ++i)
        for (std::size_t j = 0; j < rows; ++j)
            if (const double residual = fit.residuals[i * rows + j]; !std::isnan(residual))
                matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
                    residual / fit.noise[j];
    return matrix;
}

std::vector<ResidualGroup> residuals_by_height(const calibrate::ChainFit& fit) {
    std::vector<ResidualGroup> groups;
    for (std::size_t j = 0; j < fit.prediction.rows; ++j) {
        GroupSum sum;
        for (std::size_t i = 0; i < fit.times.size(); ++i)
            sum.add(fit, i, j);
        const double height = fit.model.spec.heights[j];
        groups.push_back(sum.group(height, height));
    }
    return groups;
}

std::vector<ResidualGroup> residuals_by_time(const calibrate::ChainFit& fit, std::size_t parts) {
    std::vector<GroupSum> sums(parts);
    const double last = fit.times.back();
    for (std::size_t i = 0; i < fit.times.size(); ++i) {
        if (fit.times[i] < 0.0)
            continue;
        const auto part =
            static_cast<std::size_t>(fit.times[i] / last * static_cast<double>(parts));
        sums[std::min(part, parts - 1)].add_frame(fit, i);
    }
    std::vector<ResidualGroup> groups;
    for (std::size_t k = 0; k < parts; ++k)
        groups.push_back(
            sums[k].group(last * static_cast<double>(k) / static_cast<double>(parts),
                          last * static_cast<double>(k + 1) / static_cast<double>(parts)));
    return groups;
}

std::vector<ResidualGroup> residuals_by_amplitude(const calibrate::ChainFit& fit,
                                                  const std::vector<double>& envelope,
                                                  std::size_t parts) {
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < envelope.size(); ++i)
        if (!std::isnan(envelope[i]))
            order.push_back(i);
    std::ranges::stable_sort(order, std::greater{}, [&](std::size_t i) { return envelope[i]; });
    std::vector<ResidualGroup> groups;
    for (std::size_t k = 0; k < parts && order.size() >= parts; ++k) {
        GroupSum sum;
        const std::size_t begin = order.size() * k / parts;
        const std::size_t end = order.size() * (k + 1) / parts;
        for (std::size_t place = begin; place < end; ++place)
            sum.add_frame(fit, order[place]);
        groups.push_back(sum.group(envelope[order[end - 1]], envelope[order[begin]]));
    }
    return groups;
}

double typical_noise(const calibrate::ChainFit& fit) {
    double sum = 0.0;
    for (const double noise : fit.noise)
        sum += noise * noise;
    return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(fit.noise.size(), 1)));
}

} // namespace culm::diagnose
