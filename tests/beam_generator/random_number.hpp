// SPDX-License-Identifier: BSD-3-Clause
// Random numbers that are a pure function of their use: the same on every rank.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include <Random123/philox.h>

namespace culm::beam {

enum class RandomUse : std::uint64_t { CaseDraw = 101, Noise, Outlier, Gap };

/// The position of a number in the sequence of one use.
struct RandomPlace {
    std::uint64_t seed = 1;
    RandomUse use = RandomUse::CaseDraw;
    std::uint64_t row = 0;
    std::uint64_t index = 0;
};

namespace detail {

/// In the open interval (0, 1).
[[nodiscard]] inline double unit(std::uint64_t bits) {
    return (static_cast<double>(bits >> 11) + 0.5) * 0x1p-53;
}

[[nodiscard]] inline r123::Philox4x64::ctr_type bits(const RandomPlace& place) {
    return r123::Philox4x64{}({{place.index, place.row, static_cast<std::uint64_t>(place.use), 0}},
                              {{place.seed, 0}});
}

} // namespace detail

[[nodiscard]] inline double uniform(const RandomPlace& place) {
    return detail::unit(detail::bits(place)[0]);
}

/// Standard normal, by Box and Muller's transformation.
[[nodiscard]] inline double normal(const RandomPlace& place) {
    const auto words = detail::bits(place);
    return std::sqrt(-2.0 * std::log(detail::unit(words[0]))) *
           std::cos(2.0 * std::numbers::pi * detail::unit(words[1]));
}

} // namespace culm::beam
