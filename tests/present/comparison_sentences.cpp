// SPDX-License-Identifier: BSD-3-Clause
// What culm compare says of a misfit, and what it must not say.
#include "present/comparison.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace culm::tests {
namespace {

using testing::HasSubstr;
using testing::Not;

/// A comparison of an inadequate model, with a swing far above its noise.
diagnose::Comparison misfit() {
    diagnose::Comparison comparison;
    comparison.verdict.finding = diagnose::Finding::Inadequate;
    comparison.verdict.p_value = 0.0;
    comparison.verdict.noise = 1e-5;
    comparison.verdict.rmse = 2e-5;
    comparison.verdict.is_noise_known = true;
    comparison.structure.excess_over_noise = 3.0;
    for (residuals::SwingError& third : comparison.structure.thirds) {
        third.lag_error = third.amplitude_error = 1e-4;
        third.measured_over_noise = third.modelled_over_noise = 100.0;
    }
    return comparison;
}

std::string last_sentence(const diagnose::Comparison& comparison) {
    return present::comparison_sentences(comparison).back();
}

TEST(Words, SayWhichSwingIsAhead) {
    diagnose::Comparison comparison = misfit();
    comparison.structure.phase_share = 0.9;
    comparison.structure.thirds[0].lag = 0.01;
    comparison.structure.thirds[1].lag = -0.02;
    EXPECT_EQ(
        last_sentence(comparison),
        "90 % of the remaining misfit is phase error: against the model the measured swing is "
        "0.57° behind early, 1.15° ahead in the middle, in step late (a cycle has 360°).");
}

TEST(Words, SayNothingOfThePhaseOfASwingThatHasDied) {
    diagnose::Comparison comparison = misfit();
    comparison.structure.phase_share = 0.9;
    for (residuals::SwingError& third : comparison.structure.thirds)
        third.lag = 0.01;
    comparison.structure.thirds[2].measured_over_noise = 2.0;
    EXPECT_THAT(last_sentence(comparison), HasSubstr("behind in the middle"));
    EXPECT_THAT(last_sentence(comparison), Not(HasSubstr("late")));
}

TEST(Words, SayThatTheModelStillSwingsWhereTheStemStandsStill) {
    diagnose::Comparison comparison = misfit();
    comparison.structure.amplitude_share = 0.9;
    comparison.structure.thirds[2].amplitude = -0.97;
    comparison.structure.thirds[2].measured_over_noise = 0.5;
    EXPECT_THAT(last_sentence(comparison), HasSubstr("not yet zero late (the stem rests)"));
    comparison.structure.thirds[2].modelled_over_noise = 0.5;
    EXPECT_THAT(last_sentence(comparison), Not(HasSubstr("late")));
}

TEST(Words, QuoteNoDecayOfAWindowInWhichNothingSwings) {
    diagnose::Comparison comparison = misfit();
    comparison.structure.amplitude_share = 0.9;
    residuals::WindowFit swinging;
    swinging.amplitude = 1e-3;
    swinging.decay_per_cycle = {-0.2, 0.001};
    residuals::WindowFit fallen = swinging;
    fallen.decay_per_cycle = {-136.8, 1.0};
    comparison.windows = {{0.0, 0.1, swinging, swinging}, {0.1, 0.2, swinging, swinging}};
    EXPECT_THAT(last_sentence(comparison), HasSubstr("decay per cycle goes from -0.200 to -0.200"));
    comparison.windows[1].measured = fallen;
    EXPECT_THAT(last_sentence(comparison), Not(HasSubstr("decay per cycle")));
}

TEST(Words, NameNoHeightWhereThereIsOnlyOne) {
    diagnose::Comparison comparison = misfit();
    comparison.by_time.resize(3);
    comparison.by_height.resize(1);
    EXPECT_THAT(present::comparison_sentences(comparison)[1],
                HasSubstr("The misfit is largest in the first third of the time"));
    comparison.by_height.resize(2);
    EXPECT_THAT(present::comparison_sentences(comparison)[1],
                HasSubstr("The misfit is largest at h ="));
}

} // namespace
} // namespace culm::tests
