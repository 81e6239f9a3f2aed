// SPDX-License-Identifier: BSD-3-Clause
// The release of a deflected cantilever.
#include "measure/release/release_curve.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace culm::measure {
namespace {

TEST(ReleaseCurve, BeginsAtTheHeldDeflection) {
    for (const double height : {0.2, 0.6, 1.0}) {
        const ReleaseCurve curve{height, 20.0, 0.4};
        EXPECT_EQ(curve.at(-3.0), 1.0);
        // Eight modes are complete to 1e-5 at the tip; relative errors are larger further down.
        EXPECT_NEAR(curve.at(1e-6), 1.0, 1e-4);
    }
}

TEST(ReleaseCurve, LeavesTheFirstModesShareOfTheStaticShape) {
    // At the tip mode 1 is 12/1.8751⁴ = 0.9707 of the static shape under a force there. After three
    // cycles with this damping the other modes are negligible. From rest the damped cosine is
    // larger by 1/√(1 − ζ²) at most; at a multiple of the damped period it is exp(−ζωt).
    const double decay = 0.5;
    const double damping = decay / (2.0 * std::numbers::pi);
    const double cycle = 1.0 / std::sqrt(1.0 - damping * damping); // of the undamped period 1
    const ReleaseCurve curve{1.0, 1.0, decay};
    EXPECT_NEAR(curve.at(3.0 * cycle) / (0.9707 * std::exp(-decay * 3.0 * cycle)), 1.0, 1e-4);
}

TEST(ReleaseCurve, IsScaledByThePeriod) {
    const ReleaseCurve slow{0.8, 40.0, 0.3};
    const ReleaseCurve fast{0.8, 10.0, 0.3};
    for (const double cycles : {0.01, 0.1, 0.7})
        EXPECT_NEAR(slow.at(40.0 * cycles), fast.at(10.0 * cycles), 1e-12);
}

TEST(ReleaseCurve, MovesTheTipFirst) {
    const double tip = 1.0 - ReleaseCurve{1.0, 100.0, 0.3}.at(3.0);
    const double middle = 1.0 - ReleaseCurve{0.5, 100.0, 0.3}.at(3.0);
    EXPECT_GT(tip, 1.0 - std::cos(0.06 * std::numbers::pi)); // the motion of mode 1 alone
    EXPECT_LT(std::abs(middle), 0.3 * tip);                  // relative to the held deflection
}

TEST(ReleaseCurve, PassesTheRestAfterAQuarterOfTheCycle) {
    // Mode 2 shifts the zero crossing by less than 1 %; damping delays it by atan(ζ)/2π of a cycle.
    EXPECT_NEAR((ReleaseCurve{1.0, 100.0, 0.0}.first_passage()), 25.0, 1.0);
    const double later = 100.0 * std::atan(0.1) / (2.0 * std::numbers::pi);
    EXPECT_NEAR((ReleaseCurve{1.0, 100.0, 0.2 * std::numbers::pi}.first_passage()), 25.0 + later,
                0.5);
}

} // namespace
} // namespace culm::measure
