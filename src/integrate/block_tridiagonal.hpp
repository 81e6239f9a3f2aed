// SPDX-License-Identifier: BSD-3-Clause
// Block-tridiagonal linear systems: one small block per sphere, coupled to its neighbours.
#pragma once

#include "integrate/lanes_eigen.hpp"

#include <vector>

#include <Eigen/Core>

namespace culm::integrate {

/// Gauss-Jordan elimination in place, without pivoting: SIMD lanes cannot choose different pivots,
/// and the blocks of a chain (mass, damping and stiffness of one sphere) do not need it. A singular
/// block gives infinities or NaNs, at the latest in its last element.
template <class T, int Size>
void invert_in_place(Eigen::Matrix<T, Size, Size>& block) {
    for (int k = 0; k < Size; ++k) {
        const T reciprocal = T(1.0) / block(k, k);
        block(k, k) = T(1.0);
        for (int j = 0; j < Size; ++j)
            block(k, j) = block(k, j) * reciprocal;
        for (int i = 0; i < Size; ++i) {
            if (i == k)
                continue;
            const T factor = block(i, k);
            block(i, k) = T(0.0);
            for (int j = 0; j < Size; ++j)
                block(i, j) = block(i, j) - factor * block(k, j);
        }
    }
}

/// A x = b with blocks of size Size: lower(i) x(i−1) + diagonal(i) x(i) + upper(i) x(i+1) = b(i).
/// T is double, or SIMD lanes: one system per lane.
/// Block elimination from the first block to the last, without pivoting.
template <int Size, class T = double>
class BlockTridiagonal {
  public:
    using Block = Eigen::Matrix<T, Size, Size>;
    using Column = Eigen::Matrix<T, Size, 1>;

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
            lower_[i].setConstant(T(0.0));
            diagonal_[i].setConstant(T(0.0));
            upper_[i].setConstant(T(0.0));
        }
    }

    /// Eliminates in place. Returns false when a pivot is zero or not finite, in any lane.
    [[nodiscard]] [[gnu::flatten]] bool factorise() {
        T finite = T(0.0);
        for (std::size_t i = 0; i < block_count(); ++i) {
            Block pivot = diagonal_[i];
            if (i > 0) {
                const Block factor = lower_[i].lazyProduct(diagonal_[i - 1]);
                pivot -= lower_[i].lazyProduct(upper_[i - 1]);
                lower_[i] = factor;
            }
            invert_in_place(pivot);
            diagonal_[i] = pivot;
            upper_[i] = pivot.lazyProduct(upper_[i]).eval();
            finite += pivot(Size - 1, Size - 1);
        }
        return core::all_finite(finite);
    }

    /// Solves in place after factorise().
    [[gnu::flatten]] void solve(std::vector<Column>& b) const {
        // The substitutions are chains of dependent operations. The product with the inverse pivot
        // does not belong to the chain and is computed outside of it.
        for (std::size_t i = 1; i < block_count(); ++i)
            b[i] -= lower_[i].lazyProduct(b[i - 1]);
        for (std::size_t i = 0; i < block_count(); ++i)
            b[i] = diagonal_[i].lazyProduct(b[i]).eval();
        for (std::size_t i = block_count() - 1; i-- > 0;)
            b[i] -= upper_[i].lazyProduct(b[i + 1]);
    }

  private:
    std::vector<Block> lower_;    ///< after factorise(): times the inverse pivot before it
    std::vector<Block> diagonal_; ///< after factorise(): inverses of the pivot blocks
    std::vector<Block> upper_;    ///< after factorise(): inverse pivot times it
};

} // namespace culm::integrate
