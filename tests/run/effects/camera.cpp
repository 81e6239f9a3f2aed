// SPDX-License-Identifier: BSD-3-Clause
// Effects of the camera on the readings of an unchanged stem.
#include "free_vibration.hpp"

#include <gtest/gtest.h>

namespace culm::run {
namespace {

CaseSpec filmed_case() {
    CaseSpec spec = slender_case();
    spec.store = StoreLevel::Heights;
    const double length = spec.stem.free_length();
    spec.heights = {0.25 * length, 0.5 * length, 0.99 * length};
    spec.sample_interval = 2e-3;
    spec.duration = 0.4;
    return spec;
}

std::vector<double> filmed(const CaseSpec& spec) {
    const CaseOutcome outcome = simulate(spec);
    return std::get<CaseResult>(outcome).height_deflection;
}

TEST(CameraTilt, StretchesDeflectionsInProportionToHeight) {
    CaseSpec spec = filmed_case();
    const std::vector<double> upright = filmed(spec);
    spec.effects = {active("camera_tilt", {0.04})};
    const std::vector<double> tilted = filmed(spec);
    const double shares[] = {0.25, 0.5, 0.99};
    for (std::size_t i = 0; i < upright.size(); ++i) // a few roundings
        EXPECT_NEAR(tilted[i], upright[i] * (1.0 + 0.04 * shares[i % 3]), 1e-16);
}

TEST(RollingShutter, ReadsHigherRowsLater) {
    CaseSpec spec = filmed_case();
    const std::vector<double> global = filmed(spec);
    // The row at half of the length is read one sample later, that at a quarter half a sample.
    spec.effects = {active("rolling_shutter", {2.0 * spec.sample_interval})};
    const std::vector<double> rolling = filmed(spec);
    for (std::size_t i = 1; i + 2 < spec.sample_count(); ++i) {
        EXPECT_NEAR(rolling[3 * i + 1], global[3 * (i + 1) + 1], 1e-15) << i;
        const double between = (-global[3 * (i - 1)] + 9.0 * global[3 * i] +
                                9.0 * global[3 * (i + 1)] - global[3 * (i + 2)]) /
                               16.0;
        // Cubic through four samples, 280 a cycle of mode 1 and some 45 of mode 2, by either side.
        EXPECT_NEAR(rolling[3 * i], between, 1e-5 * spec.tip_deflection) << i;
    }
}

} // namespace
} // namespace culm::run
