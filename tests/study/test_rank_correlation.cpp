// SPDX-License-Identifier: BSD-3-Clause
// Rank correlations are reached if they are possible and refused otherwise.
#include "core/error.hpp"
#include "study/design/sampling.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

namespace culm::study {
namespace {

std::vector<double> ranks(const std::vector<double>& values) {
    std::vector<std::size_t> order(values.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::sort(order, {}, [&](std::size_t i) { return values[i]; });
    std::vector<double> result(values.size());
    for (std::size_t k = 0; k < order.size(); ++k)
        result[order[k]] = static_cast<double>(k);
    return result;
}

/// Spearman's rank correlation of values without ties.
double spearman(const std::vector<double>& a, const std::vector<double>& b) {
    const auto x = ranks(a);
    const auto y = ranks(b);
    double squares = 0.0;
    for (std::size_t k = 0; k < x.size(); ++k)
        squares += (x[k] - y[k]) * (x[k] - y[k]);
    const auto n = static_cast<double>(x.size());
    return 1.0 - 6.0 * squares / (n * (n * n - 1.0));
}

const std::vector<double> three{1.0, 0.6, -0.3, 0.6, 1.0, 0.2, -0.3, 0.2, 1.0};

TEST(RankCorrelation, IsReachedByMovedPoints) {
    const RankCorrelation correlation(3, three);
    constexpr std::int64_t points = 4095;
    const auto u = sobol_points(points, 3);
    std::vector<std::vector<double>> columns(3);
    for (std::size_t k = 0; k < points; ++k) {
        std::vector<double> point(u.begin() + std::ptrdiff_t(3 * k),
                                  u.begin() + std::ptrdiff_t(3 * k + 3));
        correlation.correlate(point);
        EXPECT_EQ(point[0], u[3 * k]) << "the first coordinate stays";
        for (std::size_t j = 0; j < 3; ++j)
            columns[j].push_back(point[j]);
    }
    // Sobol points integrate smooth functions with an error of about 1/n.
    EXPECT_NEAR(spearman(columns[0], columns[1]), 0.6, 2e-3);
    EXPECT_NEAR(spearman(columns[0], columns[2]), -0.3, 2e-3);
    EXPECT_NEAR(spearman(columns[1], columns[2]), 0.2, 2e-3);
}

TEST(RankCorrelation, IsReachedByReorderedHypercubesWithTheSameValues) {
    const RankCorrelation correlation(3, three);
    std::vector<std::vector<double>> columns;
    for (const char* name : {"a", "b", "c"})
        columns.push_back(
            places_in_strata({5, name, 0}, latin_hypercube_strata({5, name, 0}, 400)));
    const auto before = columns;
    correlation.reorder(columns);
    // The chance correlation of the sample is removed; otherwise the error would be 1/√400 = 0.05.
    EXPECT_NEAR(spearman(columns[0], columns[1]), 0.6, 0.02);
    EXPECT_NEAR(spearman(columns[0], columns[2]), -0.3, 0.02);
    EXPECT_NEAR(spearman(columns[1], columns[2]), 0.2, 0.02);
    for (std::size_t k = 0; k < 3; ++k)
        EXPECT_TRUE(std::ranges::is_permutation(columns[k], before[k]));
}

TEST(RankCorrelation, IsRefusedWithTheLargestPossibleOneIfImpossible) {
    try {
        const RankCorrelation correlation(3, {1, 0.9, -0.9, 0.9, 1, 0.9, -0.9, 0.9, 1});
        FAIL();
    } catch (const core::InputError& error) {
        // Normal correlations of (0.9, −0.9, 0.9)·s are 2 sin(π 0.9 s/6) in size; the matrix is
        // singular where that is 1/2, at s = asin(1/4)·6/(0.9 π) = 0.536.
        EXPECT_NE(std::string(error.what()).find("times 0.536 or less are possible"),
                  std::string::npos)
            << error.what();
        EXPECT_NE(std::string(error.what()).find("not positive definite"), std::string::npos);
    }
    EXPECT_THROW(RankCorrelation(2, {1, 1, 1, 1}), core::InputError) << "one and the same";
}

} // namespace
} // namespace culm::study
