// SPDX-License-Identifier: BSD-3-Clause
// SIMD lanes as a scalar type: one stem per lane.
#pragma once

#include <cstddef>

#include <experimental/simd>

namespace culm::core {

/// As many doubles as the processor that the build was made for adds at once.
using Lanes = std::experimental::native_simd<double>;

inline constexpr std::size_t lane_count = Lanes::size();

} // namespace culm::core
