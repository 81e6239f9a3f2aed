// SPDX-License-Identifier: BSD-3-Clause
#include "core/vec.hpp"

#include "core/lanes.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace culm::core {
namespace {

TEST(Vec, HasACrossProductNormalToBothFactorsAndRightHanded) {
    const Vec<3, double> x{{1.0, 0.0, 0.0}};
    const Vec<3, double> y{{0.0, 1.0, 0.0}};
    EXPECT_EQ(cross(x, y)[2], 1.0);
    const Vec<3, double> a{{0.3, -1.2, 2.0}};
    const Vec<3, double> b{{-0.7, 0.1, 0.4}};
    // Rounding of three products of size one.
    EXPECT_NEAR(dot(cross(a, b), a), 0.0, 1e-15);
    EXPECT_NEAR(dot(cross(a, b), b), 0.0, 1e-15);
}

TEST(Vec, HasTheThirdComponentAsPlanarCrossProduct) {
    const Vec<2, double> a{{0.3, -1.2}};
    const Vec<2, double> b{{-0.7, 0.1}};
    const Vec<3, double> in_space =
        cross(Vec<3, double>{{0.3, -1.2, 0.0}}, Vec<3, double>{{-0.7, 0.1, 0.0}});
    EXPECT_EQ(cross(a, b), in_space[2]);
}

TEST(Lanes, ComputeAVectorInEveryLane) {
    const Lanes numbers([](auto lane) { return double(lane) + 1.0; });
    const Vec<2, Lanes> v{{numbers, numbers * numbers}};
    const Lanes squares = dot(v, v);
    for (std::size_t lane = 0; lane < lane_count; ++lane) {
        const double n = static_cast<double>(lane) + 1.0;
        EXPECT_EQ(squares[lane], n * n + n * n * n * n);
    }
}

} // namespace
} // namespace culm::core
