// SPDX-License-Identifier: BSD-3-Clause
// What share of a response's variance each group of inputs explains, by the additive regression
// y = c + Σ over groups of (linear + square of each standardised input).
// Groups are independent by design, so the share of one with q columns is
// (SSE without it − SSE of all − q s²)/SST with the residual variance s²: 0 on average for a group
// without influence. The rest is s²(n − 1)/SST = 1 − adjusted R²: interactions, higher powers and
// scatter. In an orthogonal design all add up to 1. Intervals of 95 %: jackknife over 20 blocks of
// successive points (most tests of a stem stay together), from the blocks' sums of products.
// Traps: What dependent groups (a list, failed points, few stems by chance) explain together is in
// no share. Columns that others determine (two levels have no parabola) are dropped, in each model
// anew. Levels count as equally probable. Blocks of a grid differ by its slowest factor, and a
// Sobol sequence is more even than random points: intervals are then too wide.
#pragma once

#include "reduce/population_statistics.hpp"

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace culm::reduce {

struct VarianceShares {
    std::ptrdiff_t points = 0;
    std::ptrdiff_t columns = 0; ///< of the regression, with the constant
    std::vector<Share> shares;  ///< (groups, then the rest), NaN if the response does not vary
};

/// Groups have the shape (points, inputs), the response (points, 1), all finite. Throws
/// core::NumericalError (FitFailed) for fewer than two points a column or if no input varies.
[[nodiscard]] VarianceShares variance_shares(std::vector<Eigen::MatrixXd> groups,
                                             Eigen::MatrixXd response);

} // namespace culm::reduce
