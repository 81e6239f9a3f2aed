// SPDX-License-Identifier: BSD-3-Clause
// Block-tridiagonal linear systems: one small block per sphere, coupled to its neighbours.
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/LU>

namespace culm::integrate {

/// A x = b with blocks of size Size: lower(i) x(i−1) + diagonal(i) x(i) + upper(i) x(i+1) = b(i).
/// Block elimination from the first block to the last, with partial pivoting inside the blocks.
template <int Size>
class BlockTridiagonal {
  public:
    using Block = Eigen::Matrix<double, Size, Size>;
    using Column = Eigen::Matrix<double, Size, 1>;

    explicit BlockTridiagonal(int block_count)
        : lower_(static_cast<std::size_t>(block_count)),
          diagonal_(static_cast<std::size_t>(block_count)),
          upper_(static_cast<std::size_t>(block_count)) {}

    [[nodiscard]] std::size_t block_count() const { return diagonal_.size(); }
    [[nodiscard]] Block& lower(std::size_t i) { return lower_[i]; }
    [[nodiscard]] Block& diagonal(std::size_t i) { return diagonal_[i]; }
    [[nodiscard]] Block& upper(std::size_t i) { return upper_[i]; }

    void set_zero() {
        for (std::size_t i = 0; i < block_count(); ++i) {
            lower_[i].setZero();
            diagonal_[i].setZero();
            upper_[i].setZero();
        }
    }

    /// Eliminates in place. Returns false when a pivot block is singular or not finite.
    [[nodiscard]] bool factorise() {
        for (std::size_t i = 0; i < block_count(); ++i) {
            if (i > 0) {
                lower_[i] = (lower_[i] * diagonal_[i - 1]).eval();
                diagonal_[i].noalias() -= lower_[i] * upper_[i - 1];
            }
            diagonal_[i] = Eigen::PartialPivLU<Block>(diagonal_[i]).inverse().eval();
            if (!diagonal_[i].allFinite())
                return false;
        }
        return true;
    }

    /// Solves in place after factorise().
    void solve(std::vector<Column>& b) const {
        for (std::size_t i = 1; i < block_count(); ++i)
            b[i].noalias() -= lower_[i] * b[i - 1];
        for (std::size_t i = block_count(); i-- > 0;) {
            if (i + 1 < block_count())
                b[i].noalias() -= upper_[i] * b[i + 1];
            b[i] = (diagonal_[i] * b[i]).eval();
        }
    }

  private:
    std::vector<Block> lower_;
    std::vector<Block> diagonal_; ///< after factorise(): inverses of the pivot blocks
    std::vector<Block> upper_;
};

} // namespace culm::integrate
