// SPDX-License-Identifier: BSD-3-Clause
// Selects the columns that explain a residual: forward selection, validation and resampling.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace culm::diagnose {

struct SelectedTerms {
    std::vector<std::size_t> columns; ///< chosen, the most informative first
    std::vector<double> stability;    ///< share of resamples in which each was chosen
    Eigen::VectorXd coefficients;     ///< of the chosen, least squares on everything
    double left = 0.0;                ///< square of the remainder, over that of the residual
    double validation = 0.0;          ///< the same for blocks of readings that were left out
};

/// Orthogonal forward selection. The number of terms is the smallest whose error on blocks that
/// were left out is within one standard error of the best (at most `most`). A term is kept if at
/// least 80 % of the resamples of half the blocks also select it (stability selection: Meinshausen
/// & Buehlmann 2010). `block` contains the block number of every reading. Resampling is seeded, so
/// the result is reproducible.
[[nodiscard]] SelectedTerms select_terms(const Eigen::MatrixXd& columns,
                                         const Eigen::VectorXd& residual,
                                         const std::vector<int>& block, std::size_t most);

} // namespace culm::diagnose
