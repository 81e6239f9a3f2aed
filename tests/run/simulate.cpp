// SPDX-License-Identifier: BSD-3-Clause
#include "run/simulate.hpp"

#include "reduce/ring_down/ring_down_fit.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace culm::run {
namespace {

CaseSpec short_case() {
    CaseSpec spec;
    spec.stem.sphere_count = 12;
    spec.stem.bond_damping = 10.0;
    spec.tip_deflection = 3e-3;
    spec.duration = 4e-3;
    spec.sample_interval = 1e-5;
    return spec;
}

const CaseResult& result_of(const CaseOutcome& outcome) {
    if (const auto* failure = std::get_if<CaseFailure>(&outcome))
        throw std::runtime_error(failure->reason);
    return std::get<CaseResult>(outcome);
}

TEST(Simulate, StartsAtThePrescribedDeflectionAndHasAllSamples) {
    const CaseSpec spec = short_case();
    const CaseOutcome outcome = simulate(spec);
    const auto& tip = result_of(outcome).tip_deflection;
    ASSERT_EQ(tip.size(), 401U);
    EXPECT_NEAR(tip.front(), 3e-3, 1e-15);
    for (const double deflection : tip)
        EXPECT_LE(std::abs(deflection), 3e-3 * (1 + 1e-9));
    EXPECT_GT(result_of(outcome).work.steps, 10);
}

TEST(Simulate, StoresWhatIsAskedForAndTheLevelsAgree) {
    CaseSpec spec = short_case();
    spec.store = StoreLevel::Full;
    spec.heights = {0.0, 15e-3, 31.12e-3, 40e-3};
    const CaseOutcome full = simulate(spec);
    spec.store = StoreLevel::Tip;
    const CaseOutcome tip_only = simulate(spec);
    const CaseResult& with_positions = result_of(full);
    EXPECT_EQ(with_positions.positions.size(), 401U * 12U * 3U);
    ASSERT_EQ(with_positions.height_deflection.size(), 401U * 4U);
    EXPECT_TRUE(result_of(tip_only).positions.empty());
    EXPECT_TRUE(result_of(tip_only).height_deflection.empty());
    for (std::size_t k = 0; k < 401; ++k) {
        EXPECT_EQ(with_positions.tip_deflection[k], result_of(tip_only).tip_deflection[k]);
        EXPECT_EQ(with_positions.positions[(k * 12 + 11) * 3 + 1],
                  with_positions.tip_deflection[k]);
        EXPECT_EQ(with_positions.height_deflection[4 * k], 0.0);
        EXPECT_TRUE(std::isnan(with_positions.height_deflection[4 * k + 3])) << "above the tip";
    }
    // At release the row at 15 mm lies between spheres 5 and 6: its deflection is between theirs.
    EXPECT_GT(with_positions.height_deflection[1], with_positions.positions[5 * 3 + 1]);
    EXPECT_LT(with_positions.height_deflection[1], with_positions.positions[6 * 3 + 1]);
}

TEST(Simulate, GivesTheSameFitExplicitlyAndImplicitly) {
    CaseSpec spec = short_case();
    const CaseOutcome implicit_outcome = simulate(spec);
    spec.integrator.method = IntegrationMethod::Explicit;
    spec.integrator.timestep = 2e-9;
    const CaseOutcome explicit_outcome = simulate(spec);
    std::vector<double> times;
    for (int k = 0; k <= 400; ++k)
        times.push_back(k * 1e-5);
    const auto a = reduce::fit_ring_down(times, result_of(implicit_outcome).tip_deflection);
    const auto b = reduce::fit_ring_down(times, result_of(explicit_outcome).tip_deflection);
    // With the implicit tolerance of 1e-6 per step the error is about 1e-5 of the amplitude.
    EXPECT_NEAR(a.frequency.value / b.frequency.value, 1.0, 1e-5);
    EXPECT_NEAR(a.decay_per_cycle.value / b.decay_per_cycle.value, 1.0, 1e-4);
}

TEST(Simulate, MovesInSpaceAsInThePlane) {
    CaseSpec spec = short_case();
    for (const IntegrationMethod method :
         {IntegrationMethod::Implicit, IntegrationMethod::Explicit}) {
        spec.integrator.method = method;
        spec.integrator.timestep = 1e-8;
        spec.integrator.relative_tolerance = 1e-8;
        spec.dimensions = 2;
        const CaseOutcome planar = simulate(spec);
        spec.dimensions = 3;
        const CaseOutcome spatial = simulate(spec);
        for (std::size_t k = 0; k < 401; ++k)
            EXPECT_NEAR(result_of(spatial).tip_deflection[k], result_of(planar).tip_deflection[k],
                        1e-6 * 3e-3);
    }
}

TEST(Simulate, ReturnsNonsenseParametersAsAFailureWithAReason) {
    CaseSpec spec = short_case();
    spec.stem.bond_youngs_modulus = std::nan("");
    const CaseOutcome outcome = simulate(spec);
    const auto* failure = std::get_if<CaseFailure>(&outcome);
    ASSERT_NE(failure, nullptr);
    EXPECT_EQ(failure->kind, core::FailureKind::StaticFailed);
    EXPECT_FALSE(failure->reason.empty());
}

TEST(Simulate, IsAbandonedWhenTheHeartbeatSaysSo) {
    CaseSpec spec = short_case();
    int beats = 0;
    EXPECT_THROW((void)simulate(spec, [&beats] { return ++beats < 5; }), Abandoned);
    spec.integrator.method = IntegrationMethod::Explicit;
    spec.integrator.timestep = 1e-8;
    EXPECT_THROW((void)simulate(spec, [] { return false; }), Abandoned);
}

} // namespace
} // namespace culm::run
