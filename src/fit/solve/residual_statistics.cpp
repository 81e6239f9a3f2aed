// SPDX-License-Identifier: BSD-3-Clause
#include "fit/solve/residual_statistics.hpp"

#include "fit/noise/whitening.hpp"
#include "reduce/distributions.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace culm::fit {

namespace {

/// Sums over the readings of a group.
class GroupSum {
  public:
    void add_frame(const RecordingFit& fit, std::size_t frame) {
        for (std::size_t j = 0; j < fit.prediction.rows; ++j)
            add(fit, frame, j);
    }
    void add(const RecordingFit& fit, std::size_t frame, std::size_t row) {
        const std::size_t at = frame * fit.prediction.rows + row;
        const double residual = fit.residuals[at];
        if (std::isnan(residual))
            return;
        ++readings_;
        sum_ += residual;
        squares_ += residual * residual;
        const bool is_relative = fit.noise_model && !fit.noise_model->relative.empty();
        const double noise = // of the reading
            is_relative ? fit.noise[row] * fit.noise_model->relative[at] : fit.noise[row];
        whitened_ += std::pow(residual / noise, 2);
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

Eigen::MatrixXd whitened_residuals(const RecordingFit& fit) {
    std::vector<bool> is_seen;
    for (const double residual : fit.remaining)
        is_seen.push_back(!std::isnan(residual));
    std::vector<double> values = fit.remaining;
    ReadingWeights(fit.noise, fit.noise_model, std::move(is_seen)).apply(values);
    return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
        values.data(), static_cast<Eigen::Index>(fit.times.size()),
        static_cast<Eigen::Index>(fit.noise.size()));
}

std::vector<ResidualGroup> residuals_by_height(const RecordingFit& fit) {
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

std::vector<ResidualGroup> residuals_by_time(const RecordingFit& fit, std::size_t parts) {
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

double over_noise(const RecordingFit& fit) {
    GroupSum sum;
    for (std::size_t i = 0; i < fit.times.size(); ++i)
        sum.add_frame(fit, i);
    return sum.group(0.0, 0.0).over_noise;
}

double typical_noise(const RecordingFit& fit) {
    double sum = 0.0;
    for (const double noise : fit.noise)
        sum += noise * noise;
    return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(fit.noise.size(), 1)));
}

double effective_degrees_of_freedom(const Eigen::MatrixXd& whitened, std::size_t lags) {
    const Eigen::Index frames = whitened.rows();
    const Eigen::Index rows = whitened.cols();
    const double entries = static_cast<double>(frames * rows);
    // Two separate factors, time and rows: the variance of a sum of squares of Gaussian numbers is
    // 2 Σ of squared covariances, and for the residuals of a chain that sum nearly factorises.
    double share = 0.0; // of independent frames, weighted by the rows' variances
    double weights = 0.0;
    for (Eigen::Index j = 0; j < rows; ++j) {
        const std::vector<double> row(whitened.col(j).begin(), whitened.col(j).end());
        const std::vector<double> covariance = reduce::autocovariance(row, lags);
        if (!(covariance.front() > 0.0))
            continue;
        double sum = 0.0;
        for (std::size_t k = 1; k < covariance.size(); ++k)
            sum +=
                std::pow(covariance[k] / covariance.front(), 2) - 1.0 / static_cast<double>(frames);
        share += covariance.front() / (1.0 + 2.0 * std::max(sum, 0.0));
        weights += covariance.front();
    }
    if (!(weights > 0.0))
        return std::max(entries, 1.0);
    const Eigen::MatrixXd between = whitened.transpose() * whitened;
    const double trace = between.trace();
    // White noise itself scatters the eigenvalues: (Σλ)²/Σλ² = m/(1 + m/n) on average.
    const double noise_spread = 1.0 + static_cast<double>(rows) / static_cast<double>(frames);
    const double independent_rows =
        std::min(static_cast<double>(rows), noise_spread * trace * trace / between.squaredNorm());
    return std::clamp(share / weights * static_cast<double>(frames) * independent_rows, 1.0,
                      std::max(entries, 1.0));
}

} // namespace culm::fit
