// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/fit_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>
#include <fmt/core.h>

namespace culm::calibrate {
namespace {

/// Distance from a bound, relative to the range or (logarithmic) to the value, that counts as none.
constexpr double nearness = 1e-6;
/// Directions of parameter space whose information is smaller than this share of the largest, all
/// parameters scaled alike, are beyond what differences of runs can tell.
constexpr double smallest_information = 1e-12;

void add_residuals(const measure::Measurement& measurement, ChainFit& fit) {
    const std::size_t rows = fit.prediction.rows;
    fit.residuals.resize(fit.times.size() * rows);
    double sum_of_squares = 0.0;
    for (std::size_t i = 0; i < fit.times.size(); ++i)
        for (std::size_t j = 0; j < rows; ++j) {
            double& residual = fit.residuals[i * rows + j];
            residual = measurement.deflection(i, j) - fit.prediction.readings[i * rows + j];
            if (std::isnan(residual))
                continue;
            ++fit.readings;
            sum_of_squares += residual * residual;
            fit.chi_squared += residual * residual / (fit.noise[j] * fit.noise[j]);
        }
    if (fit.readings > 0)
        fit.rmse = std::sqrt(sum_of_squares / static_cast<double>(fit.readings));
}

/// Jᵀ W J over the readings that were seen.
Eigen::MatrixXd information(const ChainFit& fit) {
    const auto count = static_cast<Eigen::Index>(fit.prediction.parameters);
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(count, count);
    for (std::size_t place = 0; place < fit.residuals.size(); ++place) {
        if (std::isnan(fit.residuals[place]))
            continue;
        const Eigen::Map<const Eigen::VectorXd> gradient(
            fit.prediction.jacobian.data() + place * fit.prediction.parameters, count);
        if (!gradient.allFinite())
            continue;
        const double noise = fit.noise[place % fit.prediction.rows];
        sum += gradient * gradient.transpose() / (noise * noise);
    }
    return sum;
}

/// Inverse of a symmetric matrix that may not have one: directions without information get an
/// infinite variance wherever they take part.
Eigen::MatrixXd inverse_information(const Eigen::MatrixXd& matrix) {
    const Eigen::Index count = matrix.rows();
    Eigen::VectorXd scale = matrix.diagonal().cwiseSqrt();
    for (double& entry : scale)
        entry = entry > 0.0 ? entry : 1.0;
    const Eigen::MatrixXd scaled =
        scale.cwiseInverse().asDiagonal() * matrix * scale.cwiseInverse().asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scaled);
    Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(count, count);
    Eigen::VectorXd unknown = Eigen::VectorXd::Zero(count);
    for (Eigen::Index k = 0; k < count; ++k) {
        const Eigen::VectorXd direction = solver.eigenvectors().col(k);
        if (solver.eigenvalues()(k) > smallest_information * solver.eigenvalues().maxCoeff())
            inverse += direction * direction.transpose() / solver.eigenvalues()(k);
        else
            unknown += direction.cwiseAbs2();
    }
    inverse = scale.cwiseInverse().asDiagonal() * inverse * scale.cwiseInverse().asDiagonal();
    for (Eigen::Index k = 0; k < count; ++k)
        if (unknown(k) > 1e-6)
            inverse(k, k) = std::numeric_limits<double>::infinity();
    return inverse;
}

/// Covariance of the parameters that are not held; rows and columns of the others are 0.
void add_covariance(const std::vector<bool>& is_held, ChainFit& fit) {
    const auto count = static_cast<Eigen::Index>(fit.prediction.parameters);
    std::vector<Eigen::Index> free;
    for (Eigen::Index k = 0; k < count; ++k)
        if (!is_held[static_cast<std::size_t>(k)])
            free.push_back(k);
    fit.covariance = Eigen::MatrixXd::Zero(count, count);
    fit.correlation = Eigen::MatrixXd::Identity(count, count);
    if (free.empty())
        return;
    const Eigen::MatrixXd all = information(fit);
    const double factor = std::max(1.0, fit.reduced_chi_squared);
    const Eigen::MatrixXd inverse = inverse_information(all(free, free));
    fit.covariance(free, free) = factor * inverse;
    for (Eigen::Index a = 0; a < count; ++a)
        for (Eigen::Index b = 0; b < count; ++b) {
            const double scale = std::sqrt(fit.covariance(a, a) * fit.covariance(b, b));
            if (a != b)
                fit.correlation(a, b) = scale > 0.0 ? fit.covariance(a, b) / scale : 0.0;
        }
}

bool is_near(const FreeParameter& parameter, double value, double bound) {
    switch (parameter.fitted_as) {
    case physics::FittedAs::Logarithm:
        return std::abs(std::log(value / bound)) < nearness;
    case physics::FittedAs::Inverse:
        return std::abs(1.0 / value - 1.0 / bound) < nearness / parameter.lower;
    case physics::FittedAs::Itself:
        break;
    }
    return std::abs(value - bound) < nearness * (parameter.upper - parameter.lower);
}

void add_parameters(const std::vector<bool>& is_held, ChainFit& fit) {
    for (const FreeParameter& parameter : fit.model.parameters) {
        const double value = parameter.access.get(fit.model.spec);
        const bool at_bound = is_near(parameter, value, parameter.lower) ||
                              is_near(parameter, value, parameter.upper);
        fit.parameters.push_back({parameter.access.name, parameter.unit, value, 0.0, at_bound,
                                  parameter.lower, parameter.upper, parameter.fitted_as,
                                  parameter.is_place, parameter.absent});
    }
    if (const double bound = fit.model.release_time_bound; bound > 0.0)
        fit.parameters.push_back({release_time_name, "s", fit.model.release_time, 0.0,
                                  bound - std::abs(fit.model.release_time) < nearness * bound,
                                  -bound, bound});
    for (std::size_t k = 0; k < fit.parameters.size(); ++k) {
        FittedParameter& parameter = fit.parameters[k];
        const auto place = static_cast<Eigen::Index>(k);
        parameter.standard_error = std::sqrt(fit.covariance(place, place));
        if (parameter.is_at_bound && !is_held[k])
            fit.reason += fmt::format(
                "{}{} is at its bound, {:.6g}{}{}", fit.reason.empty() ? "" : "; ", parameter.name,
                parameter.value, parameter.unit.empty() ? "" : " ", parameter.unit);
    }
}

} // namespace

void add_statistics(const measure::Measurement& measurement, const std::vector<bool>& is_held,
                    ChainFit& fit) {
    add_residuals(measurement, fit);
    const auto held = static_cast<std::size_t>(std::ranges::count(is_held, true));
    const std::size_t free = fit.prediction.parameters - held;
    fit.degrees_of_freedom = fit.readings > free ? fit.readings - free : 0;
    const auto degrees = static_cast<double>(std::max<std::size_t>(fit.degrees_of_freedom, 1));
    if (!fit.is_noise_known) {
        const double factor = std::sqrt(fit.chi_squared / degrees);
        for (double& noise : fit.noise)
            noise *= factor;
        fit.chi_squared = degrees;
    }
    fit.reduced_chi_squared = fit.chi_squared / degrees;
    add_covariance(is_held, fit);
    add_parameters(is_held, fit);
}

} // namespace culm::calibrate
