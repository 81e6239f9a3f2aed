// SPDX-License-Identifier: BSD-3-Clause
// Latin hypercubes made more even, and scrambled Sobol sequences.
#include "study/design/hypercube_search.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <set>
#include <vector>

#include <gtest/gtest.h>

namespace culm::study {
namespace {

Strata random_strata(std::int64_t points) {
    Strata strata;
    for (const char* name : {"a", "b", "c", "d"})
        strata.push_back(latin_hypercube_strata({1, name, 0}, points));
    return strata;
}

/// Smallest distance of two points, in strata.
double smallest_distance(const Strata& strata) {
    double smallest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < strata.front().size(); ++i)
        for (std::size_t j = 0; j < i; ++j) {
            double square = 0.0;
            for (const std::vector<std::int64_t>& column : strata)
                square += std::pow(static_cast<double>(column[i] - column[j]), 2);
            smallest = std::min(smallest, std::sqrt(square));
        }
    return smallest;
}

/// Squared centred L2 discrepancy of the strata's midpoints, by Eq. 5.6 of Hickernell (1998) over
/// all pairs.
double centred_discrepancy(const Strata& strata) {
    const std::size_t points = strata.front().size();
    const auto n = static_cast<double>(points);
    const auto z = [&](std::size_t coordinate, std::size_t point) {
        return (static_cast<double>(strata[coordinate][point]) + 0.5) / n - 0.5;
    };
    double sum = std::pow(13.0 / 12.0, static_cast<double>(strata.size()));
    for (std::size_t i = 0; i < points; ++i) {
        double single = 1.0;
        for (std::size_t c = 0; c < strata.size(); ++c)
            single *= 1.0 + 0.5 * std::abs(z(c, i)) - 0.5 * z(c, i) * z(c, i);
        sum -= 2.0 / n * single;
        for (std::size_t j = 0; j < points; ++j) {
            double pair = 1.0;
            for (std::size_t c = 0; c < strata.size(); ++c)
                pair *= 1.0 + 0.5 * std::abs(z(c, i)) + 0.5 * std::abs(z(c, j)) -
                        0.5 * std::abs(z(c, i) - z(c, j));
            sum += pair / (n * n);
        }
    }
    return sum;
}

TEST(HypercubeSearch, MaximinMovesNeighboursApart) {
    Strata strata = random_strata(60);
    const double before = smallest_distance(strata);
    spread_evenly(strata, {true, true, true, true}, HypercubeCriterion::Maximin, {1, "", 0});
    // Random hypercubes of 60 points in four dimensions have a nearest pair about 5 strata apart,
    // the best ones about 20.
    EXPECT_GT(smallest_distance(strata), 2.0 * before);
    EXPECT_GT(smallest_distance(strata), 15.0);
    for (const auto& column : strata)
        EXPECT_EQ(std::set<std::int64_t>(column.begin(), column.end()).size(), 60U);
}

TEST(HypercubeSearch, CentredDiscrepancyBecomesSmaller) {
    Strata strata = random_strata(60);
    const double before = centred_discrepancy(strata);
    spread_evenly(strata, {true, true, true, true}, HypercubeCriterion::CentredDiscrepancy,
                  {1, "", 0});
    EXPECT_LT(centred_discrepancy(strata), 0.5 * before);
}

TEST(HypercubeSearch, FixedCoordinatesStayAndTheSeedDecides) {
    const Strata start = random_strata(30);
    const auto searched = [&](std::uint64_t seed) {
        Strata strata = start;
        spread_evenly(strata, {true, false, true, true}, HypercubeCriterion::Maximin,
                      {seed, "", 0});
        return strata;
    };
    EXPECT_EQ(searched(1)[1], start[1]);
    EXPECT_EQ(searched(1), searched(1));
    EXPECT_NE(searched(1), searched(2));
}

/// Scrambled points of `dimensions` coordinates: (dimensions, points).
std::vector<std::vector<double>> scrambled(Scrambling scrambling, std::uint64_t seed,
                                           std::int64_t points) {
    constexpr std::size_t dimensions = 3;
    const auto digits = sobol_digits(points, dimensions);
    const char* names[dimensions] = {"a", "b", "c"};
    std::vector<std::vector<double>> columns(dimensions);
    for (std::size_t k = 0; k < dimensions; ++k) {
        const DigitScrambler scrambler(scrambling, {seed, names[k], 0}, points);
        for (std::int64_t i = 0; i < points; ++i)
            columns[k].push_back(
                open_unit_interval(scrambler(digits[std::size_t(i) * dimensions + k])));
    }
    return columns;
}

TEST(Scrambling, KeepsTheDigitalNet) {
    for (const Scrambling scrambling : {Scrambling::Owen, Scrambling::DigitalShift}) {
        const auto columns = scrambled(scrambling, 3, 256);
        // The first two dimensions are a (0, 8, 2)-net: each of the 256 boxes of any shape
        // 2^-a × 2^-(8−a) holds one point.
        for (int a = 0; a <= 8; ++a) {
            std::set<std::pair<int, int>> boxes;
            for (std::size_t i = 0; i < 256; ++i)
                boxes.emplace(int(columns[0][i] * std::ldexp(1.0, a)),
                              int(columns[1][i] * std::ldexp(1.0, 8 - a)));
            EXPECT_EQ(boxes.size(), 256U) << a;
        }
    }
}

TEST(Scrambling, MakesEveryPointUniform) {
    // The first point has the mean 1/2 over many seeds, with a standard deviation of 0.289/√2000.
    // The tolerance is five times this. Without scrambling the point is the origin.
    double sum = 0.0;
    for (std::uint64_t seed = 0; seed < 2000; ++seed)
        sum += scrambled(Scrambling::Owen, seed, 1)[0][0];
    EXPECT_NEAR(sum / 2000.0, 0.5, 5.0 * 0.289 / std::sqrt(2000.0));
}

TEST(Scrambling, IntegratesSmoothFunctionsBetterThanIndependentPoints) {
    // ∫ Π (1 + (u − 1/2)) = 1; the root mean square error of Owen's scrambling falls as n^-1.5.
    const auto error = [](std::int64_t points) {
        double squares = 0.0;
        constexpr int seeds = 40;
        for (std::uint64_t seed = 0; seed < seeds; ++seed) {
            const auto columns = scrambled(Scrambling::Owen, seed, points);
            double sum = 0.0;
            for (std::size_t i = 0; i < std::size_t(points); ++i)
                sum += (0.5 + columns[0][i]) * (0.5 + columns[1][i]) * (0.5 + columns[2][i]);
            squares += std::pow(sum / static_cast<double>(points) - 1.0, 2) / seeds;
        }
        return std::sqrt(squares);
    };
    // With 16 times the points the theory gives a factor of 64; independent points give 4.
    EXPECT_GT(error(64) / error(1024), 25.0);
}

} // namespace
} // namespace culm::study
