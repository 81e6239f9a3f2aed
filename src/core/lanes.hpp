// SPDX-License-Identifier: BSD-3-Clause
// SIMD lanes as a scalar type, one stem per lane, and functions for code over either scalar.
#pragma once

#include <cmath>
#include <concepts>
#include <cstddef>

#include <experimental/simd>

#ifdef __AVX512F__
#include <immintrin.h>
#endif

namespace culm::core {

/// The doubles that the processor of the build adds at once.
using Lanes = std::experimental::native_simd<double>;

inline constexpr std::size_t lane_count = Lanes::size();

/// Numbers in a scalar: one in a double, lane_count in Lanes.
template <class T>
inline constexpr std::size_t lanes_of = 1;
template <>
inline constexpr std::size_t lanes_of<Lanes> = lane_count;

/// 1/√x for x > 0.
template <class T>
[[nodiscard]] T inverse_sqrt(const T& x) {
    using std::sqrt;
    return T(1.0) / sqrt(x);
}
#ifdef __AVX512F__
/// The processor's 14 bits and one step of fifth order, which leaves an error of rounding: a root
/// and a division occupy the processor for five times as long.
[[nodiscard]] inline Lanes inverse_sqrt(const Lanes& x) {
    const Lanes guess(_mm512_rsqrt14_pd(static_cast<__m512d>(x)));
    const Lanes rest = 1.0 - x * guess * guess;
    const Lanes series = (0.5 + 0.375 * rest) + (rest * rest) * (0.3125 + 0.2734375 * rest);
    return guess + (guess * rest) * series;
}
#endif

/// Lane `lane` of a scalar.
[[nodiscard]] inline double lane(double value, std::size_t) {
    return value;
}
[[nodiscard]] inline double lane(const Lanes& value, std::size_t index) {
    return value[index];
}

/// Calls f(lane) for every lane and returns the results as one scalar.
template <class T, std::invocable<std::size_t> F>
[[nodiscard]] T by_lane(F&& f) {
    if constexpr (std::same_as<T, double>)
        return f(std::size_t{0});
    else
        return T([&f](auto lane) { return f(std::size_t{lane}); });
}

/// Whether every lane is a finite number.
[[nodiscard]] inline bool all_finite(double value) {
    return std::isfinite(value);
}
[[nodiscard]] inline bool all_finite(const Lanes& value) {
    return std::experimental::all_of(value - value == 0.0);
}

} // namespace culm::core
