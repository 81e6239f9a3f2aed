// SPDX-License-Identifier: BSD-3-Clause
// Points of the unit cube, and the counter-based random numbers that generate them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include <Random123/philox.h>

namespace culm::study {

/// Purpose of a random number; numbers for different purposes are independent.
enum class RandomPurpose : std::uint64_t {
    Draw = 1,               ///< a value of a distribution
    Permutation = 2,        ///< a step of the shuffling of Latin hypercube strata
    StratumPlace = 3,       ///< the position in a stratum
    SequenceRotation = 4,   ///< the rotation of a Sobol sequence
    SequenceScrambling = 5, ///< flips of a scrambled sequence's leading digits
    ScrambledTail = 6,      ///< its other digits
    WithinStem = 8,         ///< the scatter of a test about its stem's value
};

/// The key of a random number.
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

/// Identifies one of a study's independent one-dimensional samples.
struct SampleKey {
    std::uint64_t seed = 1;
    std::string_view factor; ///< the parameter's key
    std::int64_t replicate = 0;
};

/// One coordinate of a Latin hypercube: the strata 0 … points − 1 in random order.
[[nodiscard]] std::vector<std::int64_t> latin_hypercube_strata(const SampleKey& key,
                                                               std::int64_t points);

/// A random position in the stratum [k/points, (k+1)/points) of each point.
[[nodiscard]] std::vector<double> places_in_strata(const SampleKey& key,
                                                   const std::vector<std::int64_t>& strata);

/// Points of the Sobol sequence with the direction numbers of Joe & Kuo (2008), as 64 binary
/// digits: (points, dimensions), row-major. The first is the origin.
[[nodiscard]] std::vector<std::uint64_t> sobol_digits(std::int64_t points, std::size_t dimensions);

/// Rotates a coordinate u of (0, 1) by a random shift that belongs to the key, modulo 1.
[[nodiscard]] double rotated(double u, const SampleKey& key);

/// Randomisation of a Sobol sequence. Every scrambled point is uniform in the cube, and the points
/// together remain a digital net.
enum class Scrambling {
    None,
    Owen, ///< nested uniform scrambling (Owen 1995): a flip depends on earlier digits
};

/// One coordinate's scrambling.
class DigitScrambler {
  public:
    /// `points` is the length of the sequences.
    DigitScrambler(Scrambling scrambling, const SampleKey& key, std::int64_t points);
    [[nodiscard]] std::uint64_t operator()(std::uint64_t digits) const;

  private:
    SampleKey key_;
    Scrambling scrambling_;
    int levels_ = 0; ///< digits after which no two points of the sequence agree
    /// A random bit for each node of the binary tree of leading digits; node 2^b + leading b
    /// digits.
    std::vector<std::uint64_t> flips_;
};

} // namespace culm::study
