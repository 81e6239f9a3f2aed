// SPDX-License-Identifier: BSD-3-Clause
// Points of the unit cube: Latin hypercubes and Sobol sequences.
#pragma once

#include "study/random.hpp"

#include <cstdint>
#include <string_view>
#include <vector>

namespace culm::study {

/// Which of a study's independent one-dimensional samples is meant.
struct SampleKey {
    std::uint64_t seed = 1;
    std::string_view factor; ///< the parameter's key
    std::int64_t replicate = 0;
};

/// The place of the sample's first random number for a purpose.
[[nodiscard]] RandomKey random_key(const SampleKey& key, RandomPurpose purpose);

/// The strata 0 … points − 1 in random order.
[[nodiscard]] std::vector<std::int64_t> latin_hypercube_strata(const SampleKey& key,
                                                               std::int64_t points);

/// A random place within the stratum [k/points, (k+1)/points) of each point.
[[nodiscard]] std::vector<double> places_in_strata(const SampleKey& key,
                                                   const std::vector<std::int64_t>& strata);

/// One coordinate of a Latin hypercube of `points` points: each of the strata
/// [k/points, (k+1)/points) holds exactly one of the values, at a random place, in random order.
[[nodiscard]] std::vector<double> latin_hypercube_coordinate(const SampleKey& key,
                                                             std::int64_t points);

/// Points of the Sobol sequence with the direction numbers of Joe & Kuo (2008), as 64 binary
/// digits: (points, dimensions), row-major. The first is the origin.
[[nodiscard]] std::vector<std::uint64_t> sobol_digits(std::int64_t points, std::size_t dimensions);

/// The first `points` points of the Sobol sequence after the origin: (points, dimensions),
/// row-major, in the open unit cube.
[[nodiscard]] std::vector<double> sobol_points(std::int64_t points, std::size_t dimensions);

/// Rotates a coordinate u of (0, 1) by a random shift that belongs to the key, modulo 1.
[[nodiscard]] double rotated(double u, const SampleKey& key);

/// How a Sobol sequence is made random. Every scrambled point is uniform in the cube, and the
/// points together stay a digital net.
enum class Scrambling {
    None,
    Owen,        ///< nested uniform scrambling (Owen 1995): each digit flips by those before it
    DigitalShift ///< exclusive-or with one random number for each coordinate
};

/// One coordinate's scrambling.
class DigitScrambler {
  public:
    /// For sequences of so many points.
    DigitScrambler(Scrambling scrambling, const SampleKey& key, std::int64_t points);
    [[nodiscard]] std::uint64_t operator()(std::uint64_t digits) const;

  private:
    SampleKey key_;
    Scrambling scrambling_;
    int levels_ = 0; ///< digits after which no two points of the sequence agree
    std::uint64_t shift_ = 0;
    /// A random bit for each node of the binary tree of leading digits; node 2^b + leading b
    /// digits.
    std::vector<std::uint64_t> flips_;
};

} // namespace culm::study
