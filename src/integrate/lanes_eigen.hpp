// SPDX-License-Identifier: BSD-3-Clause
// Lets Eigen's fixed-size matrices and dual numbers hold SIMD lanes.
#pragma once

#include "core/lanes.hpp"

#include <Eigen/Core>

/// Eigen's traits of a scalar type. Sums and products of matrices work; comparisons, and therefore
/// pivoting and norms, do not.
template <>
struct Eigen::NumTraits<culm::core::Lanes> : Eigen::GenericNumTraits<culm::core::Lanes> {
    using Real = culm::core::Lanes;
    using NonInteger = culm::core::Lanes;
    using Nested = culm::core::Lanes;
    using Literal = double;
    enum {
        IsComplex = 0,
        IsInteger = 0,
        IsSigned = 1,
        RequireInitialization = 0,
        ReadCost = 1,
        AddCost = 1,
        MulCost = 1
    };
};
