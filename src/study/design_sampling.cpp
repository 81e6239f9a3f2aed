// SPDX-License-Identifier: BSD-3-Clause
#include "study/design_sampling.hpp"

#include "study/random.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include <boost/random/sobol.hpp>

namespace culm::study {

namespace {

RandomKey random_key(const SampleKey& key, RandomPurpose purpose) {
    return {key.seed, purpose, factor_id(key.factor), static_cast<std::uint64_t>(key.replicate), 0};
}

/// A number in [0, bound). The product's high half is biased by less than bound/2⁶⁴.
std::uint64_t below(std::uint64_t bound, std::uint64_t bits) {
    __extension__ using Wide = unsigned __int128;
    return static_cast<std::uint64_t>((static_cast<Wide>(bits) * bound) >> 64);
}

/// 0 … count − 1 in random order (Fisher & Yates; Durstenfeld 1964).
std::vector<std::int64_t> shuffled(RandomKey key, std::int64_t count) {
    std::vector<std::int64_t> order(static_cast<std::size_t>(count));
    std::iota(order.begin(), order.end(), std::int64_t{0});
    for (std::size_t i = order.size(); i > 1; --i) {
        key.point = i;
        std::swap(order[i - 1], order[below(i, random_bits(key))]);
    }
    return order;
}

} // namespace

std::vector<double> latin_hypercube_coordinate(const SampleKey& key, std::int64_t points) {
    const auto strata = shuffled(random_key(key, RandomPurpose::Permutation), points);
    RandomKey place = random_key(key, RandomPurpose::StratumPlace);
    const auto count = static_cast<double>(points);
    std::vector<double> coordinate(strata.size());
    for (std::size_t i = 0; i < strata.size(); ++i) {
        place.point = i;
        const auto stratum = static_cast<double>(strata[i]);
        const double u = (stratum + random_uniform(place)) / count;
        // Rounding must not carry the value into the next stratum.
        coordinate[i] = std::min(u, std::nextafter((stratum + 1.0) / count, 0.0));
    }
    return coordinate;
}

std::vector<double> sobol_points(std::int64_t points, std::size_t dimensions) {
    boost::random::sobol sequence(dimensions); // starts behind the origin by itself
    std::vector<double> coordinates(static_cast<std::size_t>(points) * dimensions);
    for (double& u : coordinates)
        u = open_unit_interval(sequence());
    return coordinates;
}

double rotated(double u, const SampleKey& key) {
    const double shifted = u + random_uniform(random_key(key, RandomPurpose::SequenceRotation));
    const double fraction = shifted - std::floor(shifted);
    return std::max(fraction, std::numeric_limits<double>::min());
}

} // namespace culm::study
