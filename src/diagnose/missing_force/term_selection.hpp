// SPDX-License-Identifier: BSD-3-Clause
// Which of many columns a residual consists of: forward selection with validation and resampling.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace culm::diagnose {

struct SelectedTerms {
    std::vector<std::size_t> columns; ///< chosen, the most telling first
    std::vector<double> stability;    ///< share of resamples in which each was chosen
    Eigen::VectorXd coefficients;     ///< of the chosen, least squares on everything
    double left = 0.0;                ///< square of what remains, over that of the residual
    double validation = 0.0;          ///< the same for blocks of readings that were left out
};

/// Orthogonal forward selection. The number of terms is the smallest whose error on blocks that
/// were left out is within one standard error of the best (at most `most`); a term stays if at
/// least 80 % of the resamples of half the blocks choose it too (stability selection: Meinshausen &
/// Buehlmann 2010). `block` numbers the block of every reading; resampling is seeded, so the answer
/// is always the same.
[[nodiscard]] SelectedTerms select_terms(const Eigen::MatrixXd& columns,
                                         const Eigen::VectorXd& residual,
                                         const std::vector<int>& block, std::size_t most);

} // namespace culm::diagnose
