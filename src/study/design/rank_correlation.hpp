// SPDX-License-Identifier: BSD-3-Clause
// Rank correlations between the coordinates of points in the unit cube.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace culm::study {

/// Spearman's rank correlations of a normal copula, turned into those of its normal variables:
/// r = 2 sin(π ρ/6) (Pearson 1907), and its Cholesky factor.
class RankCorrelation {
  public:
    RankCorrelation() = default;
    /// `rank` is symmetric with ones on the diagonal, (variables, variables), row-major. Throws
    /// core::InputError if the normal correlations are not positive definite; the message states by
    /// what factor the correlations must be reduced.
    RankCorrelation(std::size_t variables, std::vector<double> rank);

    [[nodiscard]] double rank(std::size_t i, std::size_t j) const {
        return rank_[i * variables_ + j];
    }

    /// Turns one point's independent coordinates, each uniform in (0, 1), into dependent ones.
    void correlate(std::span<double> u) const;

    /// Reorders the values of each column so that the columns have approximately these rank
    /// correlations. Each column keeps its values and therefore its strata (Iman & Conover 1982).
    /// `columns` has the shape (variables, points).
    void reorder(std::vector<std::vector<double>>& columns) const;

  private:
    std::size_t variables_ = 0;
    std::vector<double> rank_;
    std::vector<double> factor_; ///< lower triangle L, L Lᵀ = normal correlations, row-major
};

} // namespace culm::study
