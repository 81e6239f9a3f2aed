// SPDX-License-Identifier: BSD-3-Clause
// Counter-based random numbers: a number is a pure function of what it is for, so that a point's
// parameters depend neither on ranks nor on the order of computation.
#pragma once

#include <cstdint>
#include <string_view>

#include <Random123/philox.h>

namespace culm::study {

/// What a random number is used for; numbers of different purposes are independent.
enum class RandomPurpose : std::uint64_t {
    Draw = 1,               ///< a value of a distribution
    Permutation = 2,        ///< a step of the shuffling of Latin hypercube strata
    StratumPlace = 3,       ///< the place within a stratum
    SequenceRotation = 4,   ///< the rotation of a Sobol sequence
    SequenceScrambling = 5, ///< flips of a scrambled sequence's leading digits
    ScrambledTail = 6,      ///< its other digits
    HypercubeSearch = 7,    ///< an exchange between strata
    WithinStem = 8,         ///< the scatter of a test about its stem's value
};

/// The place of a random number.
struct RandomKey {
    std::uint64_t seed = 1;
    RandomPurpose purpose = RandomPurpose::Draw;
    std::uint64_t factor = 0; ///< see factor_id
    std::uint64_t replicate = 0;
    std::uint64_t point = 0; ///< of the design, or the step of a shuffle
};

/// A number that stays with a factor when others are added or reordered: the FNV-1a hash (64 bits)
/// of its key.
[[nodiscard]] constexpr std::uint64_t factor_id(std::string_view key) {
    std::uint64_t hash = 0xcbf29ce484222325U;
    for (const char c : key) {
        hash ^= static_cast<unsigned char>(c);
        hash *= 0x100000001b3U;
    }
    return hash;
}

/// 64 random bits: the first word of Philox4x64-10 (Salmon et al. 2011, Parallel random numbers:
/// as easy as 1, 2, 3).
[[nodiscard]] inline std::uint64_t random_bits(const RandomKey& key) {
    const r123::Philox4x64::ctr_type counter = {
        {key.point, key.replicate, key.factor, static_cast<std::uint64_t>(key.purpose)}};
    const r123::Philox4x64::key_type seed = {{key.seed, 0}};
    return r123::Philox4x64{}(counter, seed)[0];
}

/// Maps 64 bits to the open interval (0, 1) with a resolution of 2⁻⁵³; zero becomes 2⁻⁵⁴.
[[nodiscard]] constexpr double open_unit_interval(std::uint64_t bits) {
    const std::uint64_t high = bits >> 11;
    return high == 0 ? 0x1p-54 : static_cast<double>(high) * 0x1p-53;
}

/// A number in [0, bound). The product's high half is biased by less than bound/2⁶⁴.
[[nodiscard]] constexpr std::uint64_t random_below(std::uint64_t bound, std::uint64_t bits) {
    __extension__ using Wide = unsigned __int128;
    return static_cast<std::uint64_t>((static_cast<Wide>(bits) * bound) >> 64);
}

[[nodiscard]] inline double random_uniform(const RandomKey& key) {
    return open_unit_interval(random_bits(key));
}

} // namespace culm::study
