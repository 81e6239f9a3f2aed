// SPDX-License-Identifier: BSD-3-Clause
// Points of the unit cube: Latin hypercubes and Sobol sequences.
#pragma once

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

/// One coordinate of a Latin hypercube of `points` points: each of the strata
/// [k/points, (k+1)/points) holds exactly one of the values, at a random place, in random order.
[[nodiscard]] std::vector<double> latin_hypercube_coordinate(const SampleKey& key,
                                                             std::int64_t points);

/// The first `points` points of the Sobol sequence after the origin: (points, dimensions),
/// row-major, in the open unit cube.
[[nodiscard]] std::vector<double> sobol_points(std::int64_t points, std::size_t dimensions);

/// Rotates a coordinate u of (0, 1) by a random shift that belongs to the key, modulo 1.
[[nodiscard]] double rotated(double u, const SampleKey& key);

} // namespace culm::study
