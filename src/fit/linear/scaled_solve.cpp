// SPDX-License-Identifier: BSD-3-Clause
#include "fit/linear/scaled_solve.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include <Eigen/Eigenvalues>

namespace culm::fit {
namespace {

constexpr double least_independence = 1e-6;                                   ///< of a column
constexpr double least_information = least_independence * least_independence; ///< of an eigenvalue

/// 1 in place of 0.
Eigen::VectorXd usable(Eigen::VectorXd scale) {
    for (double& entry : scale)
        entry = entry > 0.0 ? entry : 1.0;
    return scale;
}

} // namespace

Projector::Projector(const Eigen::MatrixXd& columns)
    : columns_(columns), scale_(usable(columns.colwise().norm().transpose())) {
    solver_.setThreshold(least_independence);
    if (columns.size() > 0)
        solver_.compute(columns * scale_.cwiseInverse().asDiagonal());
}

Eigen::MatrixXd Projector::coefficients(const Eigen::MatrixXd& wanted) const {
    if (columns_.size() == 0 ||
        columns_.isZero(0.0)) // nothing moves: the solver would divide by zero
        return Eigen::MatrixXd::Zero(columns_.cols(), wanted.cols());
    return scale_.cwiseInverse().asDiagonal() * Eigen::MatrixXd(solver_.solve(wanted));
}

ScaledSpectrum::ScaledSpectrum(const Eigen::MatrixXd& matrix)
    : scale_(usable(matrix.diagonal().cwiseMax(0.0).cwiseSqrt())),
      unknown_(Eigen::VectorXd::Zero(matrix.rows())) {
    if (matrix.rows() == 0)
        return;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(
        scale_.cwiseInverse().asDiagonal() * matrix * scale_.cwiseInverse().asDiagonal());
    const Eigen::Index count = matrix.rows();
    const double least = least_information * std::max(solver.eigenvalues()(count - 1), 0.0);
    Eigen::Index known = 0; // the eigenvalues rise
    while (known < count && solver.eigenvalues()(count - 1 - known) > least)
        ++known;
    values_ = solver.eigenvalues().tail(known);
    directions_ = solver.eigenvectors().rightCols(known);
    unknown_ = solver.eigenvectors().leftCols(count - known).rowwise().squaredNorm();
}

Eigen::MatrixXd ScaledSpectrum::solve(const Eigen::MatrixXd& right) const {
    const Eigen::MatrixXd scaled = scale_.cwiseInverse().asDiagonal() * right;
    return scale_.cwiseInverse().asDiagonal() *
           (directions_ *
            (values_.cwiseInverse().asDiagonal() * (directions_.transpose() * scaled)));
}

Eigen::MatrixXd ScaledSpectrum::inverse() const {
    return solve(Eigen::MatrixXd::Identity(scale_.size(), scale_.size()));
}

Eigen::MatrixXd ScaledSpectrum::covariance() const {
    Eigen::MatrixXd covariance = inverse();
    for (Eigen::Index k = 0; k < covariance.rows(); ++k)
        if (is_unknown(k))
            covariance(k, k) = std::numeric_limits<double>::infinity();
    return covariance;
}

double ScaledSpectrum::log_determinant() const {
    const auto missing = static_cast<double>(scale_.size() - values_.size());
    return 2.0 * scale_.array().log().sum() + values_.array().log().sum() +
           missing * std::log(least_information);
}

// The active set method for convex problems (Nocedal & Wright 2006, 16.5): every pass goes to the
// minimum over the free unknowns, or to the first bound on the way.
Eigen::VectorXd bounded_minimum(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right,
                                const Eigen::VectorXd& lower, const Eigen::VectorXd& upper) {
    const Eigen::Index count = right.size();
    Eigen::VectorXd at = Eigen::VectorXd::Zero(count).cwiseMax(lower).cwiseMin(upper);
    std::vector<bool> is_fixed(static_cast<std::size_t>(count), false);
    for (Eigen::Index pass = 0; pass < 4 * count + 1; ++pass) {
        std::vector<Eigen::Index> free;
        for (Eigen::Index k = 0; k < count; ++k)
            if (!is_fixed[static_cast<std::size_t>(k)])
                free.push_back(k);
        const Eigen::VectorXd slope = right - matrix * at; // downhill
        if (!free.empty()) {
            const Eigen::VectorXd step = ScaledSpectrum(matrix(free, free)).solve(slope(free));
            double share = 1.0;
            Eigen::Index met = -1;
            for (std::size_t k = 0; k < free.size(); ++k) {
                const double way = step(static_cast<Eigen::Index>(k));
                const double room = (way > 0.0 ? upper : lower)(free[k]) - at(free[k]);
                if (way != 0.0 && room / way < share) {
                    share = std::max(room / way, 0.0);
                    met = free[k];
                }
            }
            at(free) += share * step;
            if (met >= 0) {
                at(met) = step(std::ranges::find(free, met) - free.begin()) > 0.0 ? upper(met)
                                                                                  : lower(met);
                is_fixed[static_cast<std::size_t>(met)] = true;
                continue;
            }
        }
        // At the minimum over the free unknowns: one whose bound stops no descent is freed.
        const Eigen::VectorXd rest = right - matrix * at;
        Eigen::Index best = -1;
        double largest = 0.0;
        for (Eigen::Index k = 0; k < count; ++k) {
            if (!is_fixed[static_cast<std::size_t>(k)] || !(lower(k) < upper(k)))
                continue;
            const double inward = at(k) == upper(k) ? -rest(k) : rest(k);
            const double gain = inward / std::sqrt(std::max(matrix(k, k), 1e-300));
            if (gain > std::max(largest, 1e-9)) {
                largest = gain;
                best = k;
            }
        }
        if (best < 0)
            break;
        is_fixed[static_cast<std::size_t>(best)] = false;
    }
    return at;
}

} // namespace culm::fit
