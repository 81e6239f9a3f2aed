// SPDX-License-Identifier: BSD-3-Clause
#include "run/case_lanes.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace culm::run {
namespace {

CaseSpec lane_case(std::int64_t point) {
    CaseSpec spec;
    spec.point = point;
    spec.stem.sphere_count = 10;
    spec.stem.bond_youngs_modulus = 1e9 * (1.0 + 0.3 * static_cast<double>(point));
    spec.stem.bond_damping = 2.0 + static_cast<double>(point);
    spec.tip_deflection = 1e-3 * (1.0 + 0.1 * static_cast<double>(point));
    spec.integrator.method = IntegrationMethod::Explicit;
    spec.integrator.timestep = 1e-8;
    spec.duration = 1e-3;
    spec.sample_interval = 1e-5;
    return spec;
}

TEST(ExplicitLanes, GiveTheSameBitsAloneAndWithOthers) {
    std::vector<CaseSpec> specs;
    for (std::int64_t point = 0; point < 11; ++point)
        specs.push_back(lane_case(point));
    const auto together = Simulator().simulate_together(specs);
    ASSERT_EQ(together.size(), specs.size());
    for (std::size_t k = 0; k < specs.size(); ++k) {
        const CaseOutcome alone = simulate(specs[k]);
        EXPECT_EQ(std::get<CaseResult>(alone).tip_deflection,
                  std::get<CaseResult>(together[k]).tip_deflection)
            << "case " << k;
    }
}

TEST(ExplicitLanes, DivergingLaneFailsAloneWithTheStableStepInItsReason) {
    std::vector<CaseSpec> specs{lane_case(0), lane_case(1), lane_case(2)};
    specs[1].stem.bond_damping = 500.0; // far beyond the stable step of 1e-8 s
    const auto outcomes = Simulator().simulate_together(specs);
    EXPECT_TRUE(std::holds_alternative<CaseResult>(outcomes[0]));
    EXPECT_TRUE(std::holds_alternative<CaseResult>(outcomes[2]));
    const auto* failure = std::get_if<CaseFailure>(&outcomes[1]);
    ASSERT_NE(failure, nullptr);
    EXPECT_EQ(failure->kind, core::FailureKind::Instability);
    EXPECT_NE(failure->reason.find("above the largest stable one"), std::string::npos)
        << failure->reason;
}

TEST(ExplicitLanes, CrumpledChainWithAHarmlessTipIsCalledUnstable) {
    // Just above the axial limit the instability saturates and the tip stays bounded.
    CaseSpec spec = lane_case(0);
    spec.stem.sphere_count = 12;
    spec.stem.bond_damping = 1.0;
    spec.stem.bond_youngs_modulus = 1e9;
    const double limit = largest_stable_timestep(spec);
    spec.integrator.timestep = 1.02 * limit;
    spec.sample_interval = 100 * spec.integrator.timestep;
    spec.duration = 200 * spec.sample_interval;
    EXPECT_TRUE(std::holds_alternative<CaseFailure>(simulate(spec)));
    spec.integrator.timestep = 0.98 * limit;
    spec.sample_interval = 100 * spec.integrator.timestep;
    spec.duration = 200 * spec.sample_interval;
    EXPECT_TRUE(std::holds_alternative<CaseResult>(simulate(spec)));
}

TEST(ExplicitLanes, AreSharedOnlyByCasesThatStepTogether) {
    const CaseSpec a = lane_case(0);
    EXPECT_TRUE(can_share_lanes(a, lane_case(1)));
    CaseSpec other = lane_case(1);
    other.integrator.timestep = 2e-8;
    EXPECT_FALSE(can_share_lanes(a, other));
    other = lane_case(1);
    other.stem.sphere_count = 11;
    EXPECT_FALSE(can_share_lanes(a, other));
    other = lane_case(1);
    other.integrator.method = IntegrationMethod::Implicit;
    EXPECT_FALSE(can_share_lanes(a, other));
}

} // namespace
} // namespace culm::run
