// SPDX-License-Identifier: BSD-3-Clause
// One stem with several explicit steps: agreement with ordinary runs, and the order of the error.
#include "reduce/ring_down/ring_down_fit.hpp"
#include "run/explicit_steps.hpp"
#include "run/modes.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace culm::run {
namespace {

/// Two undamped periods of a short stem.
CaseSpec stem_of(double damping, double deflection) {
    CaseSpec spec;
    spec.stem.sphere_count = 10;
    spec.stem.bond_damping = damping;
    spec.tip_deflection = deflection;
    spec.sample_interval = undamped_period(spec) / 40;
    spec.duration = 80 * spec.sample_interval;
    return spec;
}

std::int64_t steps_per_sample(const CaseSpec& spec, double fraction) {
    return static_cast<std::int64_t>(
        std::ceil(spec.sample_interval / (fraction * timestep_limits(spec).linearised())));
}

TEST(StepComparison, GivesTheHistoriesOfOrdinaryRuns) {
    const CaseSpec spec = stem_of(3.0, 3e-3);
    std::vector<std::int64_t> counts;
    for (const double fraction : {0.2, 0.5, 0.9})
        counts.push_back(steps_per_sample(spec, fraction));
    const auto outcomes = simulate_with_steps(spec, counts);
    ASSERT_EQ(outcomes.size(), 3U);
    for (std::size_t k = 0; k < 3; ++k) {
        CaseSpec ordinary = spec;
        ordinary.integrator.method = IntegrationMethod::Explicit;
        ordinary.integrator.timestep = spec.sample_interval / static_cast<double>(counts[k]);
        const auto expected = std::get<CaseResult>(simulate(ordinary));
        const auto found = std::get<CaseResult>(outcomes[k]);
        ASSERT_EQ(found.tip_deflection.size(), 81U);
        ASSERT_EQ(expected.tip_deflection.size(), 81U);
        for (std::size_t s = 0; s < 81; ++s)
            // The units of time differ, and hence the rounding of about 1e5 stable steps.
            EXPECT_NEAR(found.tip_deflection[s], expected.tip_deflection[s], 1e-10 * 3e-3);
        EXPECT_EQ(found.work.steps, 80 * counts[k]);
    }
}

TEST(StepComparison, TakesMoreStepsThanTheMachineHasLanes) {
    const CaseSpec spec = stem_of(1.0, 1e-3);
    std::vector<std::int64_t> counts;
    for (int k = 0; k < 11; ++k)
        counts.push_back(steps_per_sample(spec, 0.9) + 3 * k);
    const auto outcomes = simulate_with_steps(spec, counts);
    ASSERT_EQ(outcomes.size(), 11U);
    for (std::size_t k = 0; k < 11; ++k)
        EXPECT_EQ(std::get<CaseResult>(outcomes[k]).work.steps, 80 * counts[k]);
}

TEST(StepComparison, UnstableStepFailsAloneAndSaysWhen) {
    const CaseSpec spec = stem_of(3.0, 3e-3);
    const std::vector<std::int64_t> counts{steps_per_sample(spec, 0.9), steps_per_sample(spec, 1.2),
                                           steps_per_sample(spec, 0.5)};
    const auto outcomes = simulate_with_steps(spec, counts);
    EXPECT_TRUE(std::holds_alternative<CaseResult>(outcomes[0]));
    EXPECT_TRUE(std::holds_alternative<CaseResult>(outcomes[2]));
    const auto* failure = std::get_if<CaseFailure>(&outcomes[1]);
    ASSERT_NE(failure, nullptr);
    EXPECT_EQ(failure->kind, core::FailureKind::Instability);
    EXPECT_NE(failure->reason.find("gained energy by t = "), std::string::npos);
}

/// b1 per cycle and b2 at each step.
std::vector<reduce::RingDownFit> fits(const CaseSpec& spec,
                                      const std::vector<std::int64_t>& counts) {
    std::vector<double> times;
    for (std::size_t s = 0; s < spec.sample_count(); ++s)
        times.push_back(static_cast<double>(s) * spec.sample_interval);
    std::vector<reduce::RingDownFit> found;
    for (const CaseOutcome& outcome : simulate_with_steps(spec, counts))
        found.push_back(reduce::fit_ring_down(times, std::get<CaseResult>(outcome).tip_deflection));
    return found;
}

TEST(StepComparison, HasFirstOrderErrorsOfFittedDecayAndFrequencyWithDamping) {
    const CaseSpec spec = stem_of(5.0, 3e-3);
    const std::int64_t coarse = steps_per_sample(spec, 0.9);
    const auto found = fits(spec, {coarse, 2 * coarse, 4 * coarse});
    const auto order = [&](reduce::Estimate reduce::RingDownFit::*number) {
        const auto value = [&](std::size_t k) { return (found[k].*number).value; };
        return std::log2((value(0) - value(1)) / (value(1) - value(2)));
    };
    // Halving the step halves the error; the second-order part is a few per cent of it here.
    EXPECT_NEAR(order(&reduce::RingDownFit::decay_per_cycle), 1.0, 0.1);
    EXPECT_NEAR(order(&reduce::RingDownFit::frequency), 1.0, 0.1);
}

} // namespace
} // namespace culm::run
