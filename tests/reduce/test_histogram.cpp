// SPDX-License-Identifier: BSD-3-Clause
// Bins of histograms.
#include "reduce/population_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

namespace culm::reduce {
namespace {

std::size_t total(const Histogram& histogram) {
    return std::accumulate(histogram.counts.begin(), histogram.counts.end(), std::size_t{0});
}

TEST(Histogram, EveryValueIsCountedInTheBinThatHoldsIt) {
    std::mt19937_64 random(1);
    std::normal_distribution<double> normal(0.3, 1.7);
    std::vector<double> values(80);
    std::ranges::generate(values, [&] { return normal(random); });
    const Histogram histogram = make_histogram(values);
    ASSERT_EQ(histogram.edges.size(), histogram.counts.size() + 1);
    EXPECT_EQ(total(histogram), 80U);
    for (std::size_t k = 0; k < histogram.counts.size(); ++k) {
        const auto inside = std::ranges::count_if(values, [&](double v) {
            return v >= histogram.edges[k] && v < histogram.edges[k + 1];
        });
        EXPECT_EQ(histogram.counts[k], static_cast<std::size_t>(inside));
    }
    // Freedman & Diaconis for 80 normal values: about 8 bins; rounding up the width at most halves.
    EXPECT_GE(histogram.counts.size(), 4U);
    EXPECT_LE(histogram.counts.size(), 16U);
}

TEST(Histogram, WidthsAreRoundNumbersAndZeroIsAnEdge) {
    const Histogram histogram =
        make_histogram(std::vector<double>{-0.9, -0.4, -0.1, 0.0, 0.2, 0.3, 0.7, 1.1});
    const double width = histogram.edges[1] - histogram.edges[0];
    const double mantissa = width / std::pow(10.0, std::floor(std::log10(width) + 1e-9));
    EXPECT_TRUE(std::abs(mantissa - 1.0) < 1e-9 || std::abs(mantissa - 2.0) < 1e-9 ||
                std::abs(mantissa - 5.0) < 1e-9)
        << width;
    EXPECT_NE(std::ranges::find(histogram.edges, 0.0), histogram.edges.end());
}

TEST(Histogram, AnOutlierDoesNotMultiplyTheBins) {
    std::vector<double> values(1000);
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = 1e-3 * static_cast<double>(i);
    values.push_back(1e6);
    const Histogram histogram = make_histogram(values);
    EXPECT_LE(histogram.counts.size(), 100U);
    EXPECT_EQ(total(histogram), 1001U);
}

TEST(Histogram, CoincidingQuartilesAreNoTrouble) {
    const Histogram histogram =
        make_histogram(std::vector<double>{0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 3.0});
    EXPECT_GT(histogram.counts.size(), 1U);
    EXPECT_EQ(total(histogram), 8U);
}

TEST(Histogram, EqualValuesShareOneBinAroundThem) {
    for (const double value : {0.0, 2.5, -1e-12}) {
        const Histogram histogram = make_histogram(std::vector<double>(5, value));
        ASSERT_EQ(histogram.counts, std::vector<std::size_t>{5});
        EXPECT_LT(histogram.edges[0], value);
        EXPECT_GT(histogram.edges[1], value);
    }
}

TEST(Histogram, NoValuesGiveNoBins) {
    EXPECT_TRUE(make_histogram({}).edges.empty());
}

} // namespace
} // namespace culm::reduce
