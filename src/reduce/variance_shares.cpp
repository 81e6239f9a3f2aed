// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/variance_shares.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <fmt/core.h>

namespace culm::reduce {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Sets the mean to 0 and the variance to 1; columns that do not vary become zero.
void standardise(MatrixXd& values) {
    const auto points = static_cast<double>(values.rows());
    for (auto column : values.colwise()) {
        const double rounding = 1e-24 * column.squaredNorm();
        column.array() -= column.sum() / points;
        const double squares = column.squaredNorm();
        column *= squares > rounding ? std::sqrt(points / squares) : 0.0;
    }
}

/// Removes from sums of products what columns begin … end − 1 explain, by the Cholesky method with
/// pivoting; returns the number of columns that others do not determine.
double eliminate(MatrixXd& products, Index begin, Index end, double points) {
    constexpr double independent_share = 1e-10; // of the variance
    for (double rank = 0.0;; ++rank) {
        Index pivot = 0;
        if (begin == end || products.diagonal().segment(begin, end - begin).maxCoeff(&pivot) <=
                                independent_share * points)
            return rank;
        const VectorXd column = products.col(begin + pivot);
        products -= column * (column / column(begin + pivot)).transpose();
    }
}

/// The number of independent columns, and the shares (groups, then the rest), not confined to
/// [0, 1], from sums of products of the constant, the groups from begins[g] on, and the response.
std::pair<double, VectorXd> additive_shares(const MatrixXd& products,
                                            const std::vector<Index>& begins) {
    const double points = products(0, 0);
    const Index response = begins.back();
    MatrixXd centred = products;
    eliminate(centred, 0, 1, points);
    MatrixXd rest = centred;
    const double rank = eliminate(rest, 1, response, points);
    const double variance = rest(response, response) / (points - 1.0 - rank);
    VectorXd squares = VectorXd::Constant(std::ssize(begins), (points - 1.0) * variance);
    for (std::size_t g = 0; g + 1 < begins.size(); ++g) {
        MatrixXd without = centred;
        const double others = eliminate(without, 1, begins[g], points) +
                              eliminate(without, begins[g + 1], response, points);
        squares(static_cast<Index>(g)) =
            without(response, response) - rest(response, response) - (rank - others) * variance;
    }
    return {1.0 + rank, squares / centred(response, response)};
}

/// Sums of products over blocks of successive points; all is standardised.
std::vector<MatrixXd> sums_of_blocks(const std::vector<MatrixXd>& groups, const MatrixXd& response,
                                     const std::vector<Index>& begins) {
    const Index blocks = std::clamp<Index>(response.rows(), 1, 20);
    std::vector<MatrixXd> sums;
    for (Index k = 0; k < blocks; ++k) {
        const auto rows =
            Eigen::seq(k * response.rows() / blocks, (k + 1) * response.rows() / blocks - 1);
        MatrixXd columns = MatrixXd::Ones(rows.size(), begins.back() + 1);
        for (std::size_t g = 0; g < groups.size(); ++g)
            columns.middleCols(begins[g], 2 * groups[g].cols()) << groups[g](rows, Eigen::all),
                groups[g](rows, Eigen::all).cwiseAbs2();
        columns.rightCols(1) = response(rows, 0);
        sums.emplace_back(columns.transpose() * columns);
    }
    return sums;
}

} // namespace

VarianceShares variance_shares(std::vector<MatrixXd> groups, MatrixXd response) {
    standardise(response);
    std::vector<Index> begins{1};
    for (MatrixXd& group : groups) {
        standardise(group);
        begins.push_back(begins.back() + 2 * group.cols());
    }
    const std::vector<MatrixXd> blocks = sums_of_blocks(groups, response, begins);
    const MatrixXd all = std::accumulate(blocks.begin() + 1, blocks.end(), blocks.front());
    const auto [columns, shares] = additive_shares(all, begins);
    const std::string few = fmt::format("{} points are too few for {} columns", all(0, 0), columns);
    if (all(0, 0) < 2.0 * columns || columns < 2.0)
        throw core::NumericalError(core::FailureKind::FitFailed,
                                   columns < 2.0 ? "no input varies" : few);
    MatrixXd changes(shares.size(), std::ssize(blocks));
    for (Index k = 0; const MatrixXd& block : blocks)
        changes.col(k++) = additive_shares(all - block, begins).second - shares;
    changes.colwise() -= changes.rowwise().mean().eval();
    const double weight = 1.0 - 1.0 / static_cast<double>(blocks.size());
    const VectorXd half = normal_quantile_95 * std::sqrt(weight) * changes.rowwise().norm();
    VarianceShares found{response.rows(), std::lround(columns), {}};
    const auto confined = [](double share) { return std::clamp(share, 0.0, 1.0); };
    for (Index k = 0; k < half.size(); ++k)
        found.shares.push_back(
            {confined(shares(k)), {confined(shares(k) - half(k)), confined(shares(k) + half(k))}});
    return found;
}

} // namespace culm::reduce
