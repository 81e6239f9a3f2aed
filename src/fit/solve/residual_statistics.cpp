// SPDX-License-Identifier: BSD-3-Clause
#include "fit/solve/residual_statistics.hpp"

#include "reduce/distributions.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <boost/math/special_functions/gamma.hpp>

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

/// P(TW1 ≥ x) by the gamma distribution with the same first three moments (Chiani 2014, J.
/// Multivariate Anal. 129:69-81, Table 1).
double tracy_widom_tail(double x) {
    constexpr double shape = 46.446;
    constexpr double scale = 0.186054;
    constexpr double shift = 9.84801;
    const double place = (x + shift) / scale;
    return place <= 0.0 ? 1.0 : boost::math::gamma_q(shape, place);
}

} // namespace

Whitening whitening_of(const RecordingFit& fit) {
    std::vector<bool> is_seen;
    for (const double residual : fit.residuals)
        is_seen.push_back(!std::isnan(residual));
    return {fit.noise_model, fit.prediction.rows, is_seen};
}

Eigen::MatrixXd whitened_jacobian(const RecordingFit& fit) {
    const std::size_t count = fit.prediction.parameters;
    Eigen::MatrixXd matrix(static_cast<Eigen::Index>(fit.residuals.size()),
                           static_cast<Eigen::Index>(count));
    const Whitening whitening = whitening_of(fit);
    for (std::size_t at = 0; at < fit.residuals.size(); ++at) {
        const double* const gradient = fit.prediction.jacobian.data() + at * count;
        // Near the edge of the stem a lane may miss the row and then has no derivative, as in the
        // solution (ReadingResiduals::derivative()).
        for (std::size_t k = 0; k < count; ++k)
            matrix(static_cast<Eigen::Index>(at), static_cast<Eigen::Index>(k)) =
                std::isfinite(gradient[k]) ? gradient[k] / fit.noise[at % fit.prediction.rows]
                                           : 0.0;
    }
    for (std::size_t k = 0; k < count; ++k)
        whitening.apply({matrix.data() + k * fit.residuals.size(), fit.residuals.size()});
    return matrix;
}

Eigen::VectorXd whitened_term(const ReadingErrors::Term& term, const RecordingFit& part,
                              const Eigen::MatrixXd& jacobian) {
    std::vector<double> values(part.residuals.size(), 0.0);
    if (!term.readings.empty())
        for (std::size_t at = 0; at < values.size(); ++at)
            values[at] = term.readings[at] / part.noise[at % part.prediction.rows];
    whitening_of(part).apply(values);
    Eigen::VectorXd column =
        Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
    for (std::size_t p = 0; p < part.model.parameters.size(); ++p) {
        const physics::ParameterId& id = part.model.parameters[p].access.id;
        const double logarithm = id == physics::bond_youngs_modulus ? term.log_modulus
                                 : id == physics::bond_damping      ? term.log_damping
                                                                    : 0.0;
        if (logarithm != 0.0)
            column += logarithm * part.model.value(p) * jacobian.col(static_cast<Eigen::Index>(p));
    }
    return column;
}

LinearStep linear_step(const Eigen::MatrixXd& columns, const Eigen::VectorXd& residuals,
                       Eigen::Index first, Eigen::Index constrained) {
    Eigen::MatrixXd matrix = columns.transpose() * columns;
    matrix.diagonal().segment(first, constrained).array() += 1.0;
    const Eigen::VectorXd scale =
        matrix.diagonal().cwiseMax(std::numeric_limits<double>::min()).cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd inverse = scale.asDiagonal() *
                                    (scale.asDiagonal() * matrix * scale.asDiagonal())
                                        .completeOrthogonalDecomposition()
                                        .pseudoInverse() *
                                    scale.asDiagonal();
    return {inverse * (columns.transpose() * residuals), inverse};
}

Eigen::MatrixXd whitened_residuals(const RecordingFit& fit) {
    const std::size_t rows = fit.prediction.rows;
    std::vector<double> values;
    for (std::size_t at = 0; at < fit.residuals.size(); ++at)
        values.push_back(fit.residuals[at] / fit.noise[at % rows]);
    whitening_of(fit).apply(values);
    return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
        values.data(), static_cast<Eigen::Index>(fit.times.size()),
        static_cast<Eigen::Index>(rows));
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

std::vector<ResidualGroup> residuals_by_amplitude(const RecordingFit& fit,
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

double weighted_rms(std::span<const RecordingFit> parts,
                    const std::vector<std::vector<double>>& noise) {
    double sum = 0.0;
    std::size_t count = 0;
    std::vector<physics::ParameterId> errors;
    for (std::size_t m = 0; m < parts.size(); ++m) {
        RecordingFit part = parts[m];
        part.noise = noise[m];
        sum += whitened_residuals(part).squaredNorm();
        count += part.readings;
        // Each error term adds one residual, however many recordings share it.
        for (const FittedParameter& parameter : part.parameters)
            if (parameter.is_error && std::ranges::find(errors, parameter.id) == errors.end()) {
                errors.push_back(parameter.id);
                sum += parameter.value * parameter.value;
            }
    }
    return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0.0;
}

double rms(std::span<const RecordingFit> parts) {
    double sum = 0.0;
    std::size_t count = 0;
    for (const RecordingFit& part : parts) {
        sum += part.rmse * part.rmse * static_cast<double>(part.readings);
        count += part.readings;
    }
    return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0.0;
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

SpatialPattern spatial_pattern(const Eigen::MatrixXd& whitened) {
    SpatialPattern pattern;
    pattern.shape = Eigen::VectorXd::Zero(whitened.cols());
    const double total = whitened.squaredNorm();
    if (whitened.cols() < 2 || whitened.rows() < 10 || !(total > 0.0))
        return pattern;
    const auto n = static_cast<double>(whitened.rows());
    const auto m = static_cast<double>(whitened.cols());
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(whitened.transpose() * whitened);
    const double largest = solver.eigenvalues()(whitened.cols() - 1);
    pattern.shape = solver.eigenvectors().col(whitened.cols() - 1);
    pattern.share = largest / total;
    // Johnstone (2001), Theorem 1.1: (λ₁ − centre)/width tends to the Tracy-Widom law. The unknown
    // variance is the table's own mean square, so λ₁ is counted in units of total/(n m).
    const double root = std::sqrt(n - 1.0) + std::sqrt(m);
    const double centre = root * root;
    const double width = root * std::cbrt(1.0 / std::sqrt(n - 1.0) + 1.0 / std::sqrt(m));
    pattern.p_value = tracy_widom_tail((pattern.share * n * m - centre) / width);
    return pattern;
}

double chi_squared_tail(double value, double degrees_of_freedom) {
    return value <= 0.0 ? 1.0 : boost::math::gamma_q(0.5 * degrees_of_freedom, 0.5 * value);
}

} // namespace culm::fit
