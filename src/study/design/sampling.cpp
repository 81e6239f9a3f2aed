// SPDX-License-Identifier: BSD-3-Clause
#include "study/design/sampling.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include <boost/random/sobol.hpp>

namespace culm::study {

/// The key of the sample's first random number for a purpose.
static RandomKey random_key(const SampleKey& key, RandomPurpose purpose) {
    return {key.seed, purpose, factor_id(key.factor), static_cast<std::uint64_t>(key.replicate), 0};
}

/// In random order (Fisher & Yates; Durstenfeld 1964).
std::vector<std::int64_t> latin_hypercube_strata(const SampleKey& key, std::int64_t points) {
    RandomKey step = random_key(key, RandomPurpose::Permutation);
    std::vector<std::int64_t> order(static_cast<std::size_t>(points));
    std::iota(order.begin(), order.end(), std::int64_t{0});
    for (std::size_t i = order.size(); i > 1; --i) {
        step.point = i;
        std::swap(order[i - 1], order[random_below(i, random_bits(step))]);
    }
    return order;
}

std::vector<double> places_in_strata(const SampleKey& key,
                                     const std::vector<std::int64_t>& strata) {
    RandomKey place = random_key(key, RandomPurpose::StratumPlace);
    const auto count = static_cast<double>(strata.size());
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

std::vector<std::uint64_t> sobol_digits(std::int64_t points, std::size_t dimensions) {
    boost::random::sobol sequence(dimensions); // starts after the origin
    std::vector<std::uint64_t> digits(static_cast<std::size_t>(points) * dimensions, 0);
    for (std::size_t i = dimensions; i < digits.size(); ++i)
        digits[i] = sequence();
    return digits;
}

double rotated(double u, const SampleKey& key) {
    // A rotation modulo 1 (Cranley & Patterson 1976) keeps the evenness of the sequence and makes
    // each point uniform. Zero is excluded: inverse distribution functions are infinite there.
    const double shifted = u + random_uniform(random_key(key, RandomPurpose::SequenceRotation));
    const double fraction = shifted - std::floor(shifted);
    return std::max(fraction, std::numeric_limits<double>::min());
}

DigitScrambler::DigitScrambler(Scrambling scrambling, const SampleKey& key, std::int64_t points)
    : key_(key), scrambling_(scrambling) {
    if (scrambling == Scrambling::None)
        return;
    // Beyond log2(points) digits no two points of the sequence share a node of the tree.
    levels_ = static_cast<int>(std::bit_width(static_cast<std::uint64_t>(points)));
    flips_.resize(std::max<std::size_t>(1, (std::size_t{1} << levels_) / 64));
    RandomKey random = random_key(key, RandomPurpose::SequenceScrambling);
    for (std::uint64_t& word : flips_) {
        word = random_bits(random);
        ++random.point;
    }
}

std::uint64_t DigitScrambler::operator()(std::uint64_t digits) const {
    if (scrambling_ == Scrambling::None)
        return digits;
    std::uint64_t flipped = digits;
    std::uint64_t node = 1;
    for (int level = 0; level < levels_; ++level) {
        const std::uint64_t digit = (digits >> (63 - level)) & 1U;
        const std::uint64_t flip = (flips_[node / 64] >> (node % 64)) & 1U;
        // The flip depends on the preceding digits of the unscrambled sequence, not on the flipped
        // ones.
        flipped ^= flip << (63 - level);
        node = 2 * node + digit;
    }
    // The following digits belong to this point alone, so all their bits are independent.
    RandomKey tail = random_key(key_, RandomPurpose::ScrambledTail);
    tail.point = node;
    return flipped ^ (random_bits(tail) >> levels_);
}

} // namespace culm::study
