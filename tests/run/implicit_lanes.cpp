// SPDX-License-Identifier: BSD-3-Clause
// Implicit cases in SIMD lanes give the same results as single cases.
#include "run/case_lanes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace culm::run {
namespace {

/// Stems that differ in every property in which lanes may differ.
CaseSpec implicit_lane_case(std::int64_t point) {
    const auto place = static_cast<double>(point);
    CaseSpec spec;
    spec.point = point;
    spec.stem.sphere_count = 16;
    spec.stem.bond_youngs_modulus = 1e9 * (1.0 + 0.4 * place);
    spec.stem.bond_damping = 2.0 + 15.0 * place;
    spec.tip_deflection = 2e-3 * (1.0 + 0.1 * place);
    spec.duration = 2e-3 * (1.0 + static_cast<double>(point % 4));
    spec.sample_interval = point % 2 == 0 ? 1e-5 : 2e-5;
    return spec;
}

std::vector<CaseSpec> lane_cases(std::int64_t count) {
    std::vector<CaseSpec> specs;
    for (std::int64_t point = 0; point < count; ++point)
        specs.push_back(implicit_lane_case(point));
    return specs;
}

const std::vector<double>& tip(const CaseOutcome& outcome) {
    return std::get<CaseResult>(outcome).tip_deflection;
}

TEST(ImplicitLanes, GiveTheSameBitsWithAnyNeighbours) {
    const std::vector<CaseSpec> specs = lane_cases(11);
    const auto together = Simulator().simulate_together(specs);
    ASSERT_EQ(together.size(), specs.size());
    std::vector<CaseSpec> backwards(specs.rbegin(), specs.rend());
    const auto reversed = Simulator().simulate_together(backwards);
    for (std::size_t k = 0; k < specs.size(); ++k) {
        const CaseSpec alone[] = {specs[k]};
        const auto single = Simulator().simulate_together(alone);
        EXPECT_EQ(tip(together[k]).size(), specs[k].sample_count());
        EXPECT_EQ(tip(together[k]), tip(single.front())) << "case " << k;
        EXPECT_EQ(tip(together[k]), tip(reversed[specs.size() - 1 - k])) << "case " << k;
        EXPECT_EQ(std::get<CaseResult>(together[k]).work.steps,
                  std::get<CaseResult>(single.front()).work.steps);
    }
}

TEST(ImplicitLanes, AgreeWithASingleStemToRounding) {
    for (const int dimensions : {2, 3}) {
        std::vector<CaseSpec> specs = lane_cases(3);
        for (CaseSpec& spec : specs)
            spec.dimensions = dimensions;
        const auto together = Simulator().simulate_together(specs);
        for (std::size_t k = 0; k < specs.size(); ++k) {
            const CaseOutcome alone = simulate(specs[k]);
            // Rounding, amplified by the stiffness; a different algorithm would differ by 1e-6.
            for (std::size_t sample = 0; sample < specs[k].sample_count(); ++sample)
                ASSERT_NEAR(tip(together[k])[sample], tip(alone)[sample],
                            1e-9 * specs[k].tip_deflection)
                    << "case " << k << ", sample " << sample;
        }
    }
}

TEST(ImplicitLanes, FailOnlyForCasesWithoutASolution) {
    const auto whole = Simulator().simulate_together(lane_cases(4));
    std::vector<CaseSpec> specs = lane_cases(4);
    specs[0].stem.bond_youngs_modulus = std::numeric_limits<double>::quiet_NaN();
    specs[2].tip_deflection = std::numeric_limits<double>::quiet_NaN();
    const auto outcomes = Simulator().simulate_together(specs);
    for (const std::size_t k : {std::size_t{0}, std::size_t{2}}) {
        const auto* failure = std::get_if<CaseFailure>(&outcomes[k]);
        ASSERT_NE(failure, nullptr) << "case " << k;
        EXPECT_EQ(failure->kind, core::FailureKind::StaticFailed);
        EXPECT_FALSE(failure->reason.empty());
    }
    for (const std::size_t k : {std::size_t{1}, std::size_t{3}})
        EXPECT_EQ(tip(outcomes[k]), tip(whole[k])) << "case " << k;
}

TEST(ImplicitLanes, AreSharedByCasesOfOneToleranceAndSize) {
    const CaseSpec a = implicit_lane_case(0);
    EXPECT_TRUE(can_share_lanes(a, implicit_lane_case(3)));
    CaseSpec other = implicit_lane_case(1);
    other.integrator.relative_tolerance *= 10.0;
    EXPECT_FALSE(can_share_lanes(a, other));
    other = implicit_lane_case(1);
    other.stem.sphere_count = 17;
    EXPECT_FALSE(can_share_lanes(a, other));
    other = implicit_lane_case(1);
    other.dimensions = 3;
    EXPECT_FALSE(can_share_lanes(a, other));
}

} // namespace
} // namespace culm::run
