// SPDX-License-Identifier: BSD-3-Clause
// Sentences that culm compare must and must not print about a misfit.
#include "physics/effects/selection.hpp"
#include "present/comparison.hpp"

#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace culm::tests {
namespace {

using testing::HasSubstr;
using testing::Not;

/// A comparison of an inadequate model.
diagnose::Comparison misfit() {
    diagnose::Comparison comparison;
    comparison.verdict.finding = diagnose::Finding::Inadequate;
    comparison.verdict.p_value = 0.0;
    comparison.noise = 1e-5;
    comparison.rmse = 2e-5;
    comparison.verdict.is_noise_known = true;
    return comparison;
}

std::string last_sentence(const diagnose::Comparison& comparison) {
    return present::comparison_sentences(comparison).back();
}

TEST(Words, QuoteBothBackbonesAtTheAmplitudesThatTheReadingsDetermine) {
    diagnose::Comparison comparison = misfit();
    reduce::ModeBackbone measured;
    measured.points = {
        {.amplitude = 9e-3, .damping_ratio = 0.04, .damping_error = 1e-4, .frequency = 79.0},
        {.amplitude = 3e-3, .damping_ratio = 0.03, .damping_error = 1e-4, .frequency = 80.0},
        {.amplitude = 1e-3, .damping_ratio = 0.02, .damping_error = 0.01, .frequency = 81.0}};
    reduce::ModeBackbone modelled;
    modelled.points = {{.amplitude = 8e-3, .damping_ratio = 0.031, .frequency = 79.8},
                       {.amplitude = 2.8e-3, .damping_ratio = 0.032, .frequency = 79.9},
                       {.amplitude = 1e-3, .damping_ratio = 0.033, .frequency = 79.7}};
    comparison.backbones = {{measured}, {modelled}};
    EXPECT_EQ(last_sentence(comparison),
              "From 9 to 3 mm of amplitude the measured frequency goes from 79.00 to 80.00 Hz and "
              "the damping ratio from 0.0400 to 0.0300; the modelled ones go from 79.80 to 79.90 "
              "Hz and from 0.0310 to 0.0320.");
    comparison.backbones.measured.front().points[1].damping_error = 0.02;
    EXPECT_THAT(last_sentence(comparison), Not(HasSubstr("damping ratio")));
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

/// Adds a model of these effects and its verdict to the ladder.
void add_model(diagnose::Ladder& ladder, const std::string& effects, diagnose::Finding finding) {
    diagnose::LadderModel model;
    model.fit.status = fit::FitStatus::Fitted;
    model.fit.effects = physics::parse_effects(effects, {});
    model.comparison.emplace().verdict.finding = finding;
    ladder.models.push_back(std::move(model));
}

diagnose::Ladder ladder_with_a_useless_top() {
    diagnose::Ladder ladder;
    add_model(ladder, "", diagnose::Finding::Inadequate);
    add_model(ladder, "quadratic_drag", diagnose::Finding::Adequate);
    add_model(ladder, "quadratic_drag,taper", diagnose::Finding::Adequate);
    ladder.models[1].added = {"quadratic_drag"};
    ladder.models[1].is_gain = true;
    ladder.models[1].why = "BIC falls by 400";
    ladder.models[1].modulus_change = -0.01;
    ladder.models[1].damping_change = -0.4;
    ladder.models[2].added = {"taper"};
    ladder.models[2].compared_with = 1;
    ladder.models[2].why = "BIC rises by 8";
    return ladder;
}

TEST(Headline, NamesTheEffectsOfTheLastModelThatImproves) {
    diagnose::Ladder ladder = ladder_with_a_useless_top();
    EXPECT_EQ(present::best_model(ladder), 1U);
    EXPECT_EQ(present::comparison_headline(ladder, "T2"),
              "The published chain is inadequate for T2; with quadratic_drag it is adequate.");
    ladder.models[1].is_gain = false;
    EXPECT_EQ(present::best_model(ladder), 0U);
    EXPECT_EQ(present::comparison_headline(ladder, "T2"),
              "The published chain is inadequate for T2.");
}

TEST(Step, SaysAgainstWhichModelAndWhatItChanges) {
    diagnose::Ladder ladder = ladder_with_a_useless_top();
    EXPECT_THAT(present::step_sentences(ladder, 1),
                testing::ElementsAre("quadratic_drag improves on the baseline: BIC falls by 400.",
                                     "Y changes by -1.00 %, beta by -40.00 %."));
    EXPECT_THAT(present::step_sentences(ladder, 2),
                testing::ElementsAre(
                    "taper does not improve on baseline + quadratic_drag: BIC rises by 8."));
    ladder.models[2].added = {"quadratic_drag", "taper"};
    ladder.models[2].compared_with = 0;
    EXPECT_THAT(present::step_sentences(ladder, 2).front(),
                HasSubstr("quadratic_drag and taper together do not improve on the baseline"));
}

} // namespace
} // namespace culm::tests
