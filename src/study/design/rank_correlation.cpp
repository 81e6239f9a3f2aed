// SPDX-License-Identifier: BSD-3-Clause
#include "study/design/rank_correlation.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <boost/math/distributions/normal.hpp>
#include <fmt/format.h>

namespace culm::study {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;

double normal_score(double u) {
    return boost::math::quantile(boost::math::normal{}, u);
}

double normal_share(double z) {
    return std::clamp(boost::math::cdf(boost::math::normal{}, z),
                      std::numeric_limits<double>::min(), 1.0 - 0x1p-53);
}

/// Normal correlations for rank correlations times `share`, off the diagonal.
MatrixXd normal_correlations(const MatrixXd& rank, double share) {
    // Pearson (1907): r = 2 sin(π ρ/6), exact for a normal copula.
    MatrixXd normal = (2.0 * (rank.array() * (share * std::numbers::pi / 6.0)).sin()).matrix();
    normal.diagonal().setOnes();
    return normal;
}

double smallest_eigenvalue(const MatrixXd& matrix) {
    return Eigen::SelfAdjointEigenSolver<MatrixXd>(matrix, Eigen::EigenvaluesOnly)
        .eigenvalues()
        .minCoeff();
}

/// Variables nearer to a linear dependence than this are treated as dependent.
constexpr double least_eigenvalue = 1e-8;

/// The largest share of the correlations that is possible, rounded down to three digits.
double possible_share(const MatrixXd& rank) {
    double low = 0.0;
    double high = 1.0;
    // At a share of zero the matrix is the identity. Forty halvings reach the rounding of double.
    for (int halving = 0; halving < 40; ++halving) {
        const double middle = 0.5 * (low + high);
        (smallest_eigenvalue(normal_correlations(rank, middle)) > least_eigenvalue ? low : high) =
            middle;
    }
    return std::floor(low * 1000.0) / 1000.0;
}

/// Indices of the values in ascending order.
std::vector<std::size_t> order_of(std::span<const double> values) {
    std::vector<std::size_t> order(values.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return values[i]; });
    return order;
}

} // namespace

RankCorrelation::RankCorrelation(std::size_t variables, std::vector<double> rank)
    : variables_(variables), rank_(std::move(rank)), factor_(rank_.size()) {
    const auto n = static_cast<Index>(variables);
    const MatrixXd given = Eigen::Map<const MatrixXd>(rank_.data(), n, n);
    const MatrixXd normal = normal_correlations(given, 1.0);
    const double smallest = smallest_eigenvalue(normal);
    if (!(smallest > least_eigenvalue))
        throw core::InputError(fmt::format(
            "not positive definite (smallest eigenvalue {:.2g}): no quantities can be correlated "
            "like that; the correlations times {} or less are possible",
            smallest, possible_share(given)));
    const MatrixXd lower = Eigen::LLT<MatrixXd>(normal).matrixL();
    for (Index i = 0; i < n; ++i)
        for (Index j = 0; j <= i; ++j)
            factor_[static_cast<std::size_t>(i * n + j)] = lower(i, j);
}

void RankCorrelation::correlate(std::span<double> u) const {
    std::vector<double> z(variables_);
    std::ranges::transform(u, z.begin(), normal_score);
    for (std::size_t i = 1; i < variables_; ++i) {
        const double* row = &factor_[i * variables_];
        // A variable that does not depend on earlier ones keeps its coordinate bit for bit.
        if (row[i] == 1.0)
            continue;
        // z' = L z has the correlations L Lᵀ when the z are independent.
        u[i] = normal_share(std::inner_product(row, row + i + 1, z.begin(), 0.0));
    }
}

void RankCorrelation::reorder(std::vector<std::vector<double>>& columns) const {
    const auto n = static_cast<Index>(columns.front().size());
    const auto k = static_cast<Index>(variables_);
    MatrixXd scores(n, k);
    for (Index j = 0; j < k; ++j)
        for (Index i = 0; i < n; ++i)
            scores(i, j) = normal_score(columns[std::size_t(j)][std::size_t(i)]);
    const MatrixXd centred = scores.rowwise() - scores.colwise().mean();
    const MatrixXd covariance = centred.transpose() * centred / static_cast<double>(n);
    const Eigen::LLT<MatrixXd> by_chance(covariance);
    MatrixXd lower = MatrixXd::Zero(k, k);
    for (Index i = 0; i < k; ++i)
        for (Index j = 0; j <= i; ++j)
            lower(i, j) = factor_[static_cast<std::size_t>(i * k + j)];
    // Chance correlations of the sample are removed first if there are enough points to estimate
    // them.
    MatrixXd target = centred.transpose();
    if (by_chance.info() == Eigen::Success && n > 2 * k)
        by_chance.matrixL().solveInPlace(target);
    target = lower * target;
    for (std::size_t j = 0; j < variables_; ++j) {
        const Eigen::VectorXd wanted = target.row(static_cast<Index>(j));
        const auto order = order_of({wanted.data(), static_cast<std::size_t>(n)});
        // Iman & Conover: the k-th smallest value moves to the position of the k-th smallest target
        // score. Each column keeps its values, so a hypercube stays one.
        std::vector<double> sorted = columns[j];
        std::ranges::sort(sorted);
        for (std::size_t place = 0; place < order.size(); ++place)
            columns[j][order[place]] = sorted[place];
    }
}

} // namespace culm::study
