// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/score/score_test.hpp"

#include "core/wire.hpp"
#include "diagnosis_records.hpp"
#include "support/parameter_ids.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace culm::tests {
namespace {

diagnose::EffectScore score_of(const std::string& name, const std::string& effect, int draws = 0) {
    const auto recordings = fit::observed(recording(name));
    const fit::FitOptions options = quick_diagnosis(effect).candidate;
    const fit::Fit base = fit::fit_model({}, {}, recordings, options);
    return diagnose::score_effect(base, physics::parse_effects(effect, {}).front(), recordings,
                                  options, draws);
}

TEST(ScoreTest, PromisesNearlyTheGainThatARefitBrings) {
    const auto recordings = fit::observed(recording("T2-quadratic_drag"));
    const auto effects = physics::parse_effects("quadratic_drag", {});
    const fit::FitOptions options = quick_diagnosis("quadratic_drag").candidate;
    const fit::Fit base = fit::fit_model({}, {}, recordings, options);
    const diagnose::EffectScore score =
        diagnose::score_effect(base, effects.front(), recordings, options);
    const fit::Fit larger = fit::fit_model(effects, base, recordings, options);
    ASSERT_FALSE(larger.failed()) << larger.reason;
    // One linear step over so large a change (half of the damping) is right to a few per cent.
    EXPECT_NEAR(score.gain / (base.chi_squared - larger.chi_squared), 1.0, 0.1);
    EXPECT_EQ(score.added, 1);
    EXPECT_EQ(score.parameter, "drag_coefficient");
    // 3 σ of what a refit cannot tell, and the refit's own standard error, are the same thing.
    const fit::FittedParameter& drag = *std::ranges::find(
        larger.parameters, id("quadratic_drag.drag_coefficient"), &fit::FittedParameter::id);
    EXPECT_NEAR(score.smallest_visible / (3.0 * drag.standard_error), 1.0, 0.3);
    // Drag that goes unseen is taken for damping of the bonds.
    EXPECT_GT(score.damping_bias, 0.0);
}

TEST(ScoreTest, IsOneSidedWhereAnEffectCannotBeNegative) {
    // In T3 the clamp yields; a mass at the tip would have to be negative to look like it.
    EXPECT_LT(score_of("T3-clamp_compliance", "tip_mass").gain,
              0.05 * score_of("T3-clamp_compliance", "clamp_compliance").gain);
}

TEST(ScoreTest, GainsOfNoiseAreThoseOfChiSquared) {
    const diagnose::EffectScore score = score_of("T1-null", "rolling_shutter", 200);
    ASSERT_EQ(score.null_gains.size(), 200u);
    double mean = 0.0;
    for (const double gain : score.null_gains)
        mean += gain / 200.0;
    // χ² with one degree of freedom: mean 1 ± √(2/200), four standard errors.
    EXPECT_NEAR(mean, 1.0, 0.4);
}

TEST(ScoreTest, GainsOfNoiseHalveForAOneSidedEffect) {
    const diagnose::EffectScore score = score_of("T1-null", "quadratic_drag", 200);
    const auto none = std::ranges::count(score.null_gains, 0.0);
    EXPECT_NEAR(static_cast<double>(none), 100.0, 29.0); // √(200/4) = 7, four of them
}

TEST(ScoreTest, NamesTheSizeOfEffectsWithoutAFirstOrder) {
    const diagnose::EffectScore score = score_of("T1-null", "finite_release");
    EXPECT_TRUE(score.failure.empty()) << score.failure;
    EXPECT_EQ(score.parameter, "duration_s");
    EXPECT_GT(score.smallest_visible, 0.0);
}

TEST(ScoreTest, TravelsBetweenRanks) {
    const diagnose::EffectScore score = score_of("T1-null", "relaxation", 3);
    const diagnose::EffectScore again = core::decoded<diagnose::EffectScore>(core::encoded(score));
    EXPECT_EQ(again.effect, score.effect);
    EXPECT_EQ(again.gain, score.gain);
    EXPECT_EQ(again.smallest_visible, score.smallest_visible);
    EXPECT_EQ(again.null_gains, score.null_gains);
    EXPECT_EQ(again.direction, score.direction);
}

} // namespace
} // namespace culm::tests
