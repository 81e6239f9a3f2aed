// SPDX-License-Identifier: BSD-3-Clause
// The inverse of a small block, for doubles and for SIMD lanes.
#pragma once

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

} // namespace culm::integrate
